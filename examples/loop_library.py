"""
A library of loop shapes
========================

Many loops look alike, which a straight rod does not know. A library holds the shapes of hairpin
loops; ``le.fold`` deforms those that fit onto the stem at hand, as elastic chains that remember
their shape. One library comes with the package, and you can make your own.
"""

# %%
# From structures to a library
# ----------------------------
# Loops of 3 to 12 nucleotides are taken if their stem is a helix and their backbone is complete; a
# table says what was left out and why. Any folder of PDB and mmCIF files will do; here it is three
# structures that come with the package. The loops of 1Y26 pair with each other and are taken only
# if that is asked for.

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicSpline

import loopelastica as le
from loopelastica.datafiles import LOOPS, RNA_1Y26, RNA_2KOC, RNA_4GXY, RNA_430D

made = le.build_library([RNA_1Y26, RNA_2KOC, RNA_4GXY], "my_loops.lib", with_contacts=True)
for kind, table in le.load_library("my_loops.lib").tables():
    for k in range(len(table)):
        print(kind, table.sequence(k), table.sources[k])

# %%
# One shape, deformed by hand
# ---------------------------
# Each shape is a chain of steps from one nucleotide's backbone to the next and a frame at its end:
# a ``le.RestShape``. Deformed to a clamping it costs energy, by which one shape can be told from
# another. Here the UUCG loop of 2KOC is opened by a tenth of its length.

table = le.load_library("my_loops.lib").of_length(4)
shape = le.RestShape(table.steps_A[0], table.end_frames[0])
opened = le.Clamping(1.1 * shape.clamping.position, shape.clamping.rotation)
chain = shape.deform(opened)
print(table.sequence(0), shape, "->", chain)

# %%
# The hairpin of 430D, a GAGA loop
# --------------------------------
# It is in none of the three. It is folded as a straight rod; with the library of three structures,
# whose one loop of four nucleotides is not of its kind (``like=RNA_2KOC`` would name that loop);
# and with the library that comes with the package, from which loops with a related sequence are
# left out for an honest test.

answers = {}
for name, options in {
    "straight rod": {"shapes": "rod"},
    "my library": {"library": "my_loops.lib"},
    "shipped library": {"exclude_relatives": True},
}.items():
    (loop,) = le.fold(RNA_430D, **options)
    answers[name] = first = loop.candidates[0]
    low, middle, high = first.expected_rmsd_A
    print(f"{name:16}{first.rmsd_A:5.2f} Å off, {middle:.1f} Å ({low:.1f} to {high:.1f}) expected"
          f"  {first.shape}")  # fmt: skip

# %%
# A picture
# ---------
# Above, all loops of four nucleotides that the shipped library has, laid on each other at the 5'
# end: GNRA loops are one shape, UNCG loops another one. Below, the answers for 430D where they are,
# its own loop in black; their errors, and those to expect.

library = le.load_library(LOOPS).of_length(4, is_dna=False)
loops = [library.sequence(k)[1:-1] for k in range(len(library))]
gnra = np.array([s[0] == "G" and s[2] in "AG" and s[3] == "A" for s in loops])
uncg = np.array([s[0] == "U" and s[2:] == "CG" for s in loops])
nodes = library.nodes_A
smooth = CubicSpline(np.arange(6), nodes, axis=1)(np.linspace(0, 5, 60))
# along the chord, and away from it on the side of the mean loop
mean = nodes.mean(axis=0)
along = mean[-1] / np.linalg.norm(mean[-1])
up = mean[2] + mean[3] - (mean[2] + mean[3]) @ along * along
view = np.array([along, up / np.linalg.norm(up)])

figure = plt.figure(figsize=(10.0, 6.4), layout="constrained")
above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.05))
panels = above.subplots(1, 3, sharex=True, sharey=True)
for axes, (name, which, colour) in zip(
    panels,
    (("GNRA", gnra, "#009E73"), ("UNCG", uncg, "#D55E00"), ("others", ~(gnra | uncg), "0.4")),
    strict=True,
):
    axes.plot(*np.moveaxis(smooth[which] @ view.T, -1, 0).transpose(0, 2, 1), color=colour, lw=0.4)
    axes.set_title(f"{name}: {which.sum()} loops", fontsize=11, color=colour)
    axes.set(xlim=(-6, 24), ylim=(-4, 14), aspect="equal", xlabel="Å")
panels[0].set_ylabel("Å")

COLOURS = ("#E69F00", "#CC79A7", "#009E73")
place, errors = below.subplots(1, 2)
own = loop.backbone_A
centre = own.mean(axis=0)
axes_of_view = np.linalg.svd(own - centre, full_matrices=False)[2][:2]
# the loop above its stem
axes_of_view[1] *= np.sign((own[2] + own[3] - own[0] - own[-1]) @ axes_of_view[1])
for first, colour in zip(answers.values(), COLOURS, strict=True):
    line = first.line.points(np.linspace(0, 1, 100))
    place.plot(*((line - centre) @ axes_of_view.T).T, color=colour, lw=3.5)
place.plot(*((own - centre) @ axes_of_view.T).T, "k--", marker="o", ms=5, lw=1.2)
place.set(aspect="equal", xlabel="Å", ylabel="Å")
place.set_title("430D: three answers, and its own loop", fontsize=11)
for row, (first, colour) in enumerate(zip(answers.values(), COLOURS, strict=True)):
    low, middle, high = first.expected_rmsd_A
    errors.plot([low, high], [row, row], color=colour, lw=14, alpha=0.4, solid_capstyle="butt")
    errors.plot([middle, middle], [row - 0.17, row + 0.17], color=colour, lw=3)
    errors.plot(first.rmsd_A, row, "o", color="k", ms=7)
errors.set_yticks(range(len(answers)), list(answers))
for label, colour in zip(errors.get_yticklabels(), COLOURS, strict=True):
    label.set(color=colour, fontweight="bold")
errors.set(ylim=(len(answers) - 0.4, -0.6), xlim=(0, None))
errors.set_xlabel("RMSD (Å): ● found; bar: 80 % expected, with the median")
errors.spines[["top", "right"]].set_visible(False)
figure.savefig("loop_library.png", dpi=120)
