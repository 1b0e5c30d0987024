"""Build a hairpin and simulate it, its stem restrained: python examples/simulate_hairpin.py

The full run, 100 ps, takes half an hour on one processor; PICOSECONDS=1 makes a short one.
"""

# %% A hairpin from its sequence, with hydrogens, as a file that a force field accepts
import os

import matplotlib
import numpy as np
import openmm
from openmm import app, unit

import loopelastica as le
from loopelastica.atoms.measures import rigid_fit

matplotlib.use("Agg")
import matplotlib.pyplot as plt

picoseconds = float(os.environ.get("PICOSECONDS", "100"))
model = le.build("GGC(GCAA)GCC", rna=True, candidates=3, hydrogens=True)
print(model)
model.write("simulate_hairpin.pdb")

# %% Amber OL3 in implicit water; steps of 4 fs, since hydrogens are heavier and held at their bonds
pdb = app.PDBFile("simulate_hairpin.pdb")
force_field = app.ForceField("amber14/RNA.OL3.xml", "implicit/gbn2.xml")
system = force_field.createSystem(
    pdb.topology,
    nonbondedMethod=app.CutoffNonPeriodic,
    nonbondedCutoff=1.5 * unit.nanometer,
    constraints=app.HBonds,
    hydrogenMass=1.5 * unit.amu,
)

# %% The stem is held where it was built, 1 kcal/mol/Å² for each heavy atom
loop = {str(number) for number in model.hairpin.fold.hairpin.resid}
heavy = [atom for atom in pdb.topology.atoms() if atom.element.symbol != "H"]
in_loop = np.array([atom.residue.id in loop for atom in heavy])
places = pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
holding = openmm.CustomExternalForce("k/2 * ((x - x0)^2 + (y - y0)^2 + (z - z0)^2)")
holding.addGlobalParameter("k", 1.0 * unit.kilocalorie_per_mole / unit.angstrom**2)
for name in ("x0", "y0", "z0"):
    holding.addPerParticleParameter(name)
for atom, own in zip(heavy, in_loop, strict=True):
    if not own:
        holding.addParticle(atom.index, places[atom.index])
system.addForce(holding)

# %% Minimize, then Langevin dynamics at 300 K; seeds make it the same each time on one machine
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
n_frames = 100
steps = max(round(picoseconds / 0.004 / n_frames), 1)
frames = []
for _ in range(n_frames):
    simulation.step(steps)
    frames.append(heavy_A())

# %% Root mean square deviation of loop and stem, superposed on the stem


def rmsd_A(frame, reference, rows):
    rotation, shift = rigid_fit(frame[~in_loop], reference[~in_loop])
    away = (frame @ rotation.T + shift - reference)[rows]
    return np.sqrt((away**2).sum(axis=1).mean())


time_ps = 0.004 * steps * np.arange(1, n_frames + 1)
figure, axes = plt.subplots(figsize=(6.5, 3.8), layout="constrained")
for label, rows, color in (("loop", in_loop, "#D55E00"), ("stem", ~in_loop, "0.5")):
    for name, reference, style in (("built", start, "-"), ("minimized", minimized, "--")):
        values = [rmsd_A(frame, reference, rows) for frame in frames]
        axes.plot(time_ps, values, style, color=color, label=f"{label} to the {name} model")
        print(f"{label}, to the {name} model: {np.mean(values[n_frames // 2 :]):.2f} Å")
print(f"minimization moved the loop {rmsd_A(minimized, start, in_loop):.2f} Å")
axes.set_xlabel("time (ps)")
axes.set_ylabel("RMSD of heavy atoms (Å)")
axes.set_ylim(bottom=0)
axes.legend(frameon=False, fontsize=8, ncols=2)
axes.set_title(f"{model.sequence}, stem restrained, 300 K", fontsize=10)
figure.savefig("simulate_hairpin.png", dpi=130)
