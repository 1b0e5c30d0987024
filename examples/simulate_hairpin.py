"""
From a sequence to a simulation
===============================

A hairpin is built from its sequence, with all its atoms and hydrogens, and handed to OpenMM as it
is: no other program adds or mends anything. The stem is held where it was built, the loop is free,
and the question is how far it moves. This page simulates 0.4 ps, which takes some
seconds; ``PICOSECONDS=100 python simulate_hairpin.py`` makes a full run of half an hour.
"""

# %%
# A hairpin from its sequence
# ---------------------------
# Brackets enclose the loop. The model is sound if its bonds, angles, hands and contacts are.

import os

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial.transform import Rotation

import loopelastica as le

try:
    import openmm
    from openmm import app, unit
except ImportError:
    raise SystemExit("this example needs OpenMM: pip install 'loopelastica[md]'") from None

picoseconds = float(os.environ.get("PICOSECONDS", "0.4"))
model = le.build("GGC(GCAA)GCC", rna=True, candidates=3, hydrogens=True)
model.write("simulate_hairpin.pdb")
low, middle, high = model.hairpin.fold.candidates[0].expected_rmsd_A
print(model)
print(f"error to expect of the loop: {middle:.1f} Å, in 80 % of cases {low:.1f} to {high:.1f} Å")

# %%
# Into OpenMM
# -----------
# Amber OL3 in implicit water; steps of 4 fs, since hydrogens are heavier and held at their bonds.

pdb = app.PDBFile("simulate_hairpin.pdb")
force_field = app.ForceField("amber14/RNA.OL3.xml", "implicit/gbn2.xml")
system = force_field.createSystem(
    pdb.topology,
    nonbondedMethod=app.CutoffNonPeriodic,
    nonbondedCutoff=1.5 * unit.nanometer,
    constraints=app.HBonds,
    hydrogenMass=1.5 * unit.amu,
)

# %%
# Each heavy atom of the stem is held with 1 kcal/mol/Å². (To hold the loop near its line instead,
# as firmly as the error to expect allows, add ``le.restraints(model, pdb.topology)``.)

loop = {str(number) for number in model.hairpin.fold.hairpin.resid}
heavy = [atom for atom in pdb.topology.atoms() if atom.element.symbol != "H"]
in_loop = np.array([atom.residue.id in loop for atom in heavy])
places = pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
holding = openmm.CustomExternalForce("k/2 * ((x - x0)^2 + (y - y0)^2 + (z - z0)^2)")
holding.addGlobalParameter("k", 1.0 * unit.kilocalorie_per_mole / unit.angstrom**2)
for name in ("x0", "y0", "z0"):
    holding.addPerParticleParameter(name)
system.addForce(holding)
for atom, own in zip(heavy, in_loop, strict=True):
    if not own:
        holding.addParticle(atom.index, places[atom.index])

# %%
# Minimize, then dynamics
# -----------------------
# Langevin dynamics at 300 K; seeds make it the same each time on one machine.

integrator = openmm.LangevinMiddleIntegrator(300.0, 1.0, 0.004)
integrator.setRandomNumberSeed(1)
simulation = app.Simulation(
    pdb.topology,
    system,
    integrator,
    openmm.Platform.getPlatformByName("CPU"),
    {"Threads": "1", "DeterministicForces": "true"},
)
simulation.context.setPositions(pdb.positions)


def heavy_A():
    state = simulation.context.getState(positions=True)
    found = state.getPositions(asNumpy=True).value_in_unit(unit.angstrom)
    return np.array(found)[[atom.index for atom in heavy]]


start = heavy_A()
simulation.minimizeEnergy(maxIterations=500 if picoseconds >= 10 else 50)
minimized = heavy_A()
simulation.context.setVelocitiesToTemperature(300.0, 1)
n_frames = 100 if picoseconds >= 1 else 25
steps = max(round(picoseconds / 0.004 / n_frames), 1)
frames = []
for _ in range(n_frames):
    simulation.step(steps)
    frames.append(heavy_A())

# %%
# How far it moves
# ----------------
# Root mean square deviation of loop and stem, frames superposed on the stem.


def superposed(frame, reference):
    centre = reference[~in_loop].mean(axis=0)
    own = frame[~in_loop].mean(axis=0)
    turn, _ = Rotation.align_vectors(reference[~in_loop] - centre, frame[~in_loop] - own)
    return turn.apply(frame - own) + centre


def rmsd_A(frame, reference, rows):
    away = (superposed(frame, reference) - reference)[rows]
    return np.sqrt((away**2).sum(axis=1).mean())


curves = {
    (label, name): [rmsd_A(frame, reference, rows) for frame in frames]
    for label, rows in (("loop", in_loop), ("stem", ~in_loop))
    for name, reference in (("built", start), ("minimized", minimized))
}
for (label, name), values in curves.items():
    print(f"{label}, to the {name} model: {np.mean(values[n_frames // 2 :]):.2f} Å")
print(f"minimization moved the loop {rmsd_A(minimized, start, in_loop):.2f} Å")

# %%
# A picture
# ---------
# On the left the built hairpin in bold with some frames of the simulation, stem in grey and loop in
# colour; on the right how far they are from where they began.

figure, (sticks, axes) = plt.subplots(
    1, 2, figsize=(9.2, 4.4), width_ratios=(0.8, 1.4), layout="constrained"
)
row_of = {atom.index: row for row, atom in enumerate(heavy)}
bonds = [(row_of[a.index], row_of[b.index]) for a, b in pdb.topology.bonds()
         if a.index in row_of and b.index in row_of]  # fmt: skip
up, across, _ = np.linalg.svd(start - start.mean(axis=0), full_matrices=False)[2]
up *= np.sign((start[in_loop].mean(axis=0) - start.mean(axis=0)) @ up)
drawn = [(superposed(frame, start), 0.6, 0.2) for frame in frames[::5]] + [(start, 2.0, 1.0)]
for frame, width, alpha in drawn:
    for a, b in bonds:
        ends = frame[[a, b]] - start.mean(axis=0)
        colour = "#D55E00" if in_loop[a] and in_loop[b] else "0.55"
        sticks.plot(ends @ across, ends @ up, color=colour, lw=width, alpha=alpha,
                    solid_capstyle="round")  # fmt: skip
sticks.set_aspect("equal")
sticks.axis("off")
time_ps = 0.004 * steps * np.arange(1, n_frames + 1)
for (label, name), values in curves.items():
    colour, style = "#D55E00" if label == "loop" else "0.55", "-" if name == "built" else "--"
    axes.plot(time_ps, values, style, color=colour, label=f"{label}, to the {name} model")
axes.set_xlabel("time (ps)")
axes.set_ylabel("RMSD of heavy atoms (Å)")
axes.set_ylim(bottom=0)
axes.spines[["top", "right"]].set_visible(False)
figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize=9)
figure.suptitle(f"{model.sequence}: Amber OL3, stem restrained, 300 K", fontsize=11)
figure.savefig("simulate_hairpin.png", dpi=120)
