"""
Fill the gaps of a crystal structure
====================================

Two stretches of the adenosylcobalamin riboswitch 4GXY were not seen in the crystal. The file's
sequence of record says which nucleotides are missing; an elastic line is led from the last one that
is there to the next through what stands around, and gets all its atoms. No atom that is there
moves.
"""

# %%
# What is missing
# ---------------
# The file comes with the package. What becomes of each gap is a row of a table: whether it was
# filled, whether its bonds, angles, hands and contacts are sound, and the error to expect. That
# error is calibrated on strands that were taken out of other structures.

import matplotlib.pyplot as plt
import MDAnalysis as mda
import numpy as np
from matplotlib.collections import LineCollection
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

import loopelastica as le
from loopelastica.datafiles import RNA_4GXY

filling = le.fill(RNA_4GXY)
for strand in filling.strands:
    low, middle, high = strand.expected_rmsd_A
    print(
        f"{strand.name} {strand.sequence}: {strand.status}, sound: {strand.sound}, {strand.shape}"
    )
    print(f"  error to expect {middle:.1f} Å, in 80 % of cases {low:.1f} to {high:.1f} Å")

# %%
# What a user should be aware of, and the completed structure in the format of the input.

for note in filling.notes:
    print("note:", note)
print("written to", filling.write("filled.pdb"))

# %%
# A picture
# ---------
# On the left the whole riboswitch, its backbone a smooth line through the atoms C4'. On the right
# each gap from nearby, turned so that it is seen broadside, with the atoms that were built. The
# shades say how far off they may be: half of all such strands lie within the darker one, nine in
# ten within the lighter.


COLOURS = ("#0072B2", "#D55E00")
BETWEEN = 8  # pieces of line from one nucleotide to the next

universe = mda.Universe("filled.pdb")
chain = universe.select_atoms("chainID A and name C4'")
chain = chain[np.isin(chain.resids, np.arange(1, 173))]
phase = np.arange(0, len(chain) - 1 + 1e-9, 1 / BETWEEN)
line = CubicSpline(np.arange(len(chain)), chain.positions)(phase)
number = np.interp(phase, np.arange(len(chain)), chain.resids)


def broadside(points):
    """Axes of the view in which some points are spread most."""
    return np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]


def draw(axes, view, centre, width):
    """Draw the chain: nearer parts over further ones, which are paler; what was built in colour."""
    seen = (line - centre) @ view.T
    depth = (seen[:, 2] - seen[:, 2].min()) / np.ptp(seen[:, 2])
    pieces, colours = [], []
    for k in np.argsort(depth[1:]):
        colour = str(0.85 - 0.4 * depth[k])
        for strand, own in zip(filling.strands, COLOURS, strict=True):
            if int(strand.first) - 1 <= number[k] < int(strand.last) + 1:
                colour = own
        # a white edge, and over it the piece with those beside it, for smooth joints
        here = seen[k : k + 2, :2]
        pieces += [here + 0.2 * (here - here[::-1]), seen[max(k - 1, 0) : k + 3, :2]]
        colours += ["white", colour]
    widths = np.tile([2.2 * width, width], len(pieces) // 2)
    axes.add_collection(LineCollection(pieces, colors=colours, linewidths=widths, capstyle="butt"))


def scale(axes, x, y):
    axes.plot([x, x + 10.0], [y, y], "k-", lw=2.5, solid_capstyle="butt", zorder=6)
    paper = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    axes.text(x + 5.0, y + 1.0, "10 Å", ha="center", fontsize=9, bbox=paper, zorder=5)
    axes.set_aspect("equal")
    axes.axis("off")


figure = plt.figure(figsize=(11.0, 6.4))
overview = figure.add_axes((0.0, 0.02, 0.54, 0.9))
view, centre = broadside(line), line.mean(axis=0)
draw(overview, view, centre, 3.5)
overview.autoscale_view()
overview.set_title(f"4GXY: {len(chain)} nucleotides, ten of them built", fontsize=11)
scale(overview, overview.get_xlim()[0], overview.get_ylim()[0])

for row, (strand, colour) in enumerate(zip(filling.strands, COLOURS, strict=True)):
    low, middle, high = strand.expected_rmsd_A
    own = (number >= int(strand.first) - 1) & (number <= int(strand.last) + 1)
    view, centre = broadside(line[own]), line[own].mean(axis=0)
    near = figure.add_axes((0.56, 0.51 - 0.5 * row, 0.44, 0.42))
    wide, tall = 26.0, 14.0
    draw(near, view, centre, 6.0)
    # how far each point of the picture is from the strand
    points = np.stack(np.meshgrid(np.linspace(-wide, wide, 400), np.linspace(-tall, tall, 250)), -1)
    away = cKDTree(((line[own] - centre) @ view.T)[:, :2]).query(points)[0]
    for error, shade in ((high, 0.15), (middle, 0.25)):
        near.contourf(
            points[..., 0], points[..., 1], away, [0, error], colors=[colour], alpha=shade, zorder=1
        )
    atoms = np.concatenate([r.positions_A for r in strand.candidates[0].atoms.residues])
    atoms = (atoms - centre) @ view.T
    bonds = cKDTree(atoms).query_pairs(1.9, output_type="ndarray")
    near.add_collection(LineCollection(atoms[bonds][:, :, :2], colors="0.15", lw=1.2))
    near.set_xlim(-wide, wide)
    near.set_ylim(-tall, tall)
    near.set_title(
        f"{strand.name}, {strand.sequence}: {middle:.1f} Å to expect", fontsize=11, color=colour
    )
    scale(near, -wide + 1.0, -tall + 0.5)
figure.savefig("fill_strand.png", dpi=120)
