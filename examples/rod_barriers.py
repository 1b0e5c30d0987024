"""
Barriers between the shapes of a rod
====================================

A clamped rod has several stable shapes. To go from one to another it must pass a saddle, whose
energy is the barrier. ``le.barriers`` finds the lowest pass between each two minima.
"""

# %%
# Minima and passes
# -----------------
# The clamping is that of Fig. 6 of Ameline et al., J. Comput. Phys. 373 (2018) 736. Minima that
# differ by a full turn of the end cannot be reached from each other with both ends clamped; two
# such turns can be undone by leading the rod over its end.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb

import loopelastica as le

clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
rods = le.equilibria(clamping)
barriers = le.barriers(rods)
minima = [i for i, rod in enumerate(rods) if rod.index == 0]
for barrier in barriers:
    a, b = barrier.minima
    pair = f"{rods[a].energy:6.2f} and {rods[b].energy:6.2f}"
    print(f"{pair}: " + (barrier.message or f"over {barrier.energy:.2f}"))

# %%
# A disconnectivity graph
# -----------------------
# Each minimum is a line that ends at its energy; lines meet at the lowest pass between them. Minima
# that never meet belong to different numbers of turns.


# groups of minima that lower passes have joined: members, the two groups they are of, energy
groups = [({i}, None, rods[i].energy) for i in minima]
saddles = {}
for barrier in sorted((b for b in barriers if b.saddle is not None), key=lambda b: b.energy):
    one, other = (next(g for g in groups if i in g[0]) for i in barrier.minima)
    if one is not other:
        merged = (one[0] | other[0], (one, other), barrier.energy)
        groups = [g for g in groups if g is not one and g is not other] + [merged]
        saddles[barrier.energy] = barrier.saddle

figure = plt.figure(figsize=(10.0, 6.4))
graph = figure.add_axes((0.08, 0.06, 0.42, 0.84))
colours = dict(zip(minima, ("#0072B2", "#56B4E9", "#009E73", "#CC79A7", "#E69F00"), strict=False))
top = 1.12 * max(energy for _, _, energy in groups)


def draw(group, ceiling, left=0):
    """Draw a group up to an energy; its place, and the first place free beside it."""
    members, parts, energy = group
    if parts is None:
        (i,) = members
        place, free, colour = left, left + 1, colours[i]
        graph.plot(place, energy, "o", color=colour, ms=10)
        graph.text(place, energy - 3.0, f"{energy:.2f}", ha="center", va="top", fontsize=10)
    else:
        one, free = draw(parts[0], energy, left)
        other, free = draw(parts[1], energy, free)
        place, colour = (one + other) / 2, "0.3"
        graph.plot([one, other], [energy, energy], color=colour, lw=2)
        label = {"ha": "right", "va": "center", "color": "#D55E00"}
        graph.text(one - 0.12, energy, f"pass {energy:.2f}", **label)
    graph.plot([place, place], [energy, ceiling], color=colour, lw=2, zorder=1)
    return place, free


left = 0
for group in sorted(groups, key=lambda group: min(rods[i].energy for i in group[0])):
    start = left
    _, left = draw(group, top, left)
    turns = sorted(rods[i].turns for i in group[0])
    name = ", ".join(f"{t:+d}".replace("-", "−") if t else "0" for t in turns)
    graph.text(
        (start + left - 1) / 2, top + 1.0, f"{name} turns", ha="center", va="bottom", fontsize=10
    )
graph.set_xlim(-1.4, left - 0.4)
graph.set_ylim(0.0, top)
graph.set_xticks([])
graph.set_ylabel("energy (K0/L)")
graph.spines[["top", "right", "bottom"]].set_visible(False)

# %%
# The shapes themselves: the minima in the colours of the graph, and the passes between them.

light = np.array([0.3, -0.6, 0.74])


def tube(axes, rod, colour, radius=0.022):
    line, frames = rod.centerline(160), rod.frames(160)
    angle = np.linspace(0.0, 2.0 * np.pi, 19)
    outward = np.einsum("nik,kj->nji", frames[:, :, :2], [np.cos(angle), np.sin(angle)])
    faces = np.tile(to_rgb(colour), (160, 19, 1)) * (0.7 + 0.3 * (outward @ light)[:, :, None])
    surface = np.moveaxis(line[:, None] + radius * outward, -1, 0)
    axes.plot_surface(*surface, facecolors=faces, rstride=1, cstride=1, shade=False, lw=0)
    for end, way in ((0, -1.0), (-1, 1.0)):
        clamp = np.array([line[end], line[end] + 0.1 * way * frames[end, :, 2]])
        axes.plot(*clamp.T, color="0.4", lw=5, solid_capstyle="butt")


shown = [(rods[i], colours[i]) for i in minima] + [(rod, "#D55E00") for rod in saddles.values()]
for k, (rod, colour) in enumerate(shown[:9]):
    place = (0.52 + 0.16 * (k % 3), 0.63 - 0.31 * (k // 3), 0.16, 0.27)
    axes = figure.add_axes(place, projection="3d")
    tube(axes, rod, colour)
    axes.text2D(0.3, 0.25, f"{rod.energy:.2f}", ha="center", color=colour, transform=axes.transAxes)
    axes.set_axis_off()
    axes.view_init(12, -35)
    for name, middle in zip("xyz", (-0.12, -0.02, 0.27), strict=True):
        getattr(axes, f"set_{name}lim")(middle - 0.36, middle + 0.36)
    axes.set_box_aspect((1, 1, 1), zoom=1.5)
figure.savefig("rod_barriers.png", dpi=120)
