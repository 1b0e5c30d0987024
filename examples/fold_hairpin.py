"""
Fold the loop of a hairpin
==========================

The UUCG loop of 2KOC is folded from its stem alone: an elastic rod, or the shape that such loops
have, clamped to the two strands of the stem. The loop that the NMR structure has is only compared
with, where it is; nothing is superposed.
"""

# %%
# Every hairpin loop of the file
# ------------------------------
# Here it is one. The stem is found from the coordinates, and so are the ends of the loop.

import matplotlib.pyplot as plt
import MDAnalysis as mda
import numpy as np

import loopelastica as le
from loopelastica.datafiles import RNA_2KOC

(loop,) = le.fold(RNA_2KOC)
print(loop.hairpin)
print("closed by", *loop.hairpin.closing_pair)

# %%
# Several answers, the one that was measured to be nearest to real loops first. Each has the error
# to expect of it, which is calibrated on loops that it has not seen; the error that it has here is
# known because the file has the loop.

print(" #  to expect  here    E/K0     shape")
for c in loop.candidates:
    low, middle, high = c.expected_rmsd_A
    print(f"{c.rank:2}  {middle:5.1f} Å {c.rmsd_A:7.2f} Å {c.energy_per_A:6.3f}/Å  {c.shape}")

# %%
# Where the first answer puts the backbone of each loop nucleotide, in the coordinates of the file.

for residue, point in zip(loop.hairpin.residues, loop.candidates[0].trace, strict=True):
    print(residue, point.round(1))

# %%
# A picture
# ---------
# The stem's backbone in grey, three of the answers in colour and the loop of the file in black,
# from two sides. On the right how far each nucleotide is from where the file has it, and, as bars,
# the error to expect of each answer.


COLOURS = ("#0072B2", "#E69F00", "#CC79A7")
chosen = loop.candidates[:3]
labels = [f"{c.rank}: {c.shape.split(',')[0]}" for c in chosen]

# centroids of the backbone, closing nucleotide to closing nucleotide
own = loop.backbone_A
stem = mda.Universe(RNA_2KOC).select_atoms("name C4'")
first, last = loop.hairpin.resid[[0, -1]]
sides = [stem[stem.resids < first].positions, stem[stem.resids > last].positions]
everything = np.concatenate([own, *sides])
middle = everything.mean(axis=0)
up, across, depth = np.linalg.svd(everything - middle, full_matrices=False)[2]
if (own.mean(axis=0) - middle) @ up < 0:
    up, across = -up, -across

figure = plt.figure(figsize=(9.6, 5.0), layout="constrained")
grid = figure.add_gridspec(1, 3, width_ratios=(1.0, 1.0, 1.6))
left = figure.add_subplot(grid[0])
for axes, sideways in ((left, across), (figure.add_subplot(grid[1], sharey=left), depth)):

    def draw(points, axes=axes, sideways=sideways, **style):
        points = points - middle
        axes.plot(points @ sideways, points @ up, solid_capstyle="round", **style)

    for strand, end in zip(sides, ("5'", "3'"), strict=True):
        draw(strand, color="0.78", lw=7)
        x, y = (strand[0 if end == "5'" else -1] - middle) @ np.array([sideways, up]).T
        axes.text(x, y, end, ha="center", va="center", fontsize=10)
    for c, colour in reversed(list(zip(chosen, COLOURS, strict=True))):
        draw(c.line.points(100), color=colour, lw=5 if c.rank == 1 else 2.5)
    draw(own, color="k", lw=1.2, ls="--")
    draw(own[1:-1], color="k", marker="o", ms=4.5, ls="")
    axes.set_aspect("equal")
    axes.margins(0.12)
    axes.set_xlabel("Å")
    axes.label_outer()
left.set_ylabel("Å")

errors = figure.add_subplot(grid[2])
n = len(loop.hairpin)
for k, (c, colour, label) in enumerate(zip(chosen, COLOURS, labels, strict=True)):
    shift = 0.18 * (k - 1)
    away = np.linalg.norm(c.trace - own[1:-1], axis=1)
    errors.plot(np.arange(n) + shift, away, "o", color=colour, ms=7, label=label)
    low, expected, high = c.expected_rmsd_A
    errors.plot([n + shift] * 2, [low, high], color=colour, lw=6, alpha=0.45)
    errors.plot(n + shift, expected, "_", color=colour, ms=13, mew=2.5)
errors.axvline(n - 0.5, color="0.8", lw=1)
names = [residue.split(".")[-1] for residue in loop.hairpin.residues]
errors.set_xticks(np.arange(n + 1), [*names, "expected\n(10, 50, 90 %)"])
errors.set_ylim(bottom=0)
errors.set_ylabel("distance to the file's backbone (Å)")
errors.spines[["top", "right"]].set_visible(False)
handles = [*errors.get_lines()[::3][:3], plt.Line2D([], [], color="k", marker="o", ms=4.5, ls="--")]
figure.legend(handles, [*labels, "the file's own loop"], loc="outside lower center", ncols=4,
              frameon=False)  # fmt: skip
figure.savefig("fold_hairpin.png", dpi=120)
