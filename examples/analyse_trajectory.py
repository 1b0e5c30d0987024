"""
Follow a loop through a trajectory
==================================

``LoopElastica`` is an MDAnalysis analysis: it folds every hairpin loop in every frame, each time
from the frame's own stem. A trajectory need not have the loop at all; where it has, the answer is
compared with it. Here the twenty NMR models of 2KOC serve as frames.
"""

# %%
# A Universe and an analysis
# --------------------------

import warnings

import matplotlib.pyplot as plt
import MDAnalysis as mda
import numpy as np

import loopelastica as le
from loopelastica.datafiles import RNA_2KOC

with warnings.catch_warnings(action="ignore"):  # what MDAnalysis says of the file
    universe = mda.Universe(RNA_2KOC, dt=1.0)
analysis = le.LoopElastica(universe).run()
print(analysis.hairpins)
print(analysis.n_frames, "frames, failures:", analysis.results.failures)

# %%
# The results are arrays over frames and loops; a table has a row for each of both.

table = le.to_dataframe(analysis)
print(table.head().to_string(index=False))
print(table["rmsd_A"].describe()[["min", "50%", "max"]].round(2).to_string())

# %%
# The same with two processes
# ---------------------------
# MDAnalysis cuts the trajectory and gives the parts to the workers; the results are equal to the
# last bit. A script that starts processes keeps its work behind this condition, for on macOS and
# Windows each process reads the script again.

if __name__ == "__main__":
    parallel = le.LoopElastica(universe).run(backend="multiprocessing", n_workers=2)
    print("equal:", (parallel.results.traces_A == analysis.results.traces_A).all())

# %%
# How far to trust it
# -------------------
# The error to expect is that of the first frame's answer; the band holds 80 % of such loops.

low, expected, high = le.fold(RNA_2KOC, all_models=False)[0].candidates[0].expected_rmsd_A
within = ((table["rmsd_A"] > low) & (table["rmsd_A"] < high)).mean()
print(f"expected {expected:.2f} Å, in 80 % of cases {low:.2f} to {high:.2f} Å; here {within:.0%}")

# %%
# A picture
# ---------
# Above, the error in each frame and the band in which it was expected; below, the energy of the
# line. On the right, all frames where the file has them, a point for each nucleotide's backbone:
# the stems in grey, the loops in black, and in blue the traces that were folded on these stems.


BLUE = "#0072B2"
figure = plt.figure(figsize=(9.6, 5.0), layout="constrained")
grid = figure.add_gridspec(2, 2, width_ratios=(1.5, 1.0))
errors = figure.add_subplot(grid[0, 0])
errors.axhspan(low, high, color=BLUE, alpha=0.15, lw=0, label="80 % expected")
errors.axhline(expected, color=BLUE, lw=1, ls="--", label="median expected")
errors.plot(table["frame"], table["rmsd_A"], "o-", color=BLUE, ms=5, lw=1, label="found")
errors.set_ylim(bottom=0)
errors.set_ylabel("RMSD to the frame's\nown loop (Å)")
errors.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0)
energies = figure.add_subplot(grid[1, 0], sharex=errors)
energies.plot(table["frame"], 1000 * table["energy_per_A"], "o-", color="#D55E00", ms=5, lw=1)
energies.set_ylim(bottom=0)
energies.set_ylabel("E/K0 (1/1000 Å)")
energies.set_xlabel("frame")
energies.set_xticks(range(0, analysis.n_frames, 2))
errors.tick_params(labelbottom=False)

(hairpin,) = analysis.hairpins
backbone = universe.select_atoms("name P O5' C5' C4' C3' O3'")
frames = np.array([backbone.center_of_geometry(compound="residues") for _ in universe.trajectory])
middle = frames.mean(axis=(0, 1))
up, across, _ = np.linalg.svd(frames[0] - middle, full_matrices=False)[2]
first, last = np.flatnonzero(np.isin(backbone.residues.resids, hairpin.resid))[[0, -1]]
up *= np.sign((frames[0][first] - middle) @ up)
shapes = figure.add_subplot(grid[:, 1])
for frame, trace in zip(frames, analysis.trace_A(0), strict=True):
    for points, colour, width in (
        (frame[: first + 1], "0.8", 1),
        (frame[last:], "0.8", 1),
        (frame[first : last + 1], "0.2", 0.7),
        (trace, BLUE, 1.2),
    ):
        shapes.plot((points - middle) @ across, (points - middle) @ up, color=colour, lw=width)
shapes.set_aspect("equal")
shapes.set_xlabel("Å")
shapes.set_ylabel("Å")
handles = [plt.Line2D([], [], color=c, lw=2) for c in ("0.8", "0.2", BLUE)]
shapes.legend(handles, ["stem", "loop of the file", "folded"], frameon=False,
              loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0)  # fmt: skip
figure.savefig("analyse_trajectory.png", dpi=120)
