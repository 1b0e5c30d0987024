"""Minima of a clamped rod and the passes between them: python examples/rod_barriers.py"""

# %% All equilibria of the clamping of Fig. 6 of doi:10.1016/j.jcp.2018.07.021, and their barriers
import loopelastica as le

clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
rods = le.equilibria(clamping)
barriers = le.barriers(rods)
for barrier in barriers:
    print(barrier.minima, barrier.message or round(barrier.energy, 3))

# %% A disconnectivity graph: minima end where they lie, and meet at the lowest pass between them
from matplotlib.figure import Figure  # noqa: E402

figure = Figure(figsize=(5, 4))
axes = figure.add_subplot()
axes.set(ylabel="energy (K0/L)", xticks=[])
# groups of minima that lower passes have joined: members, place, energy
groups = [({i}, None, rod.energy) for i, rod in enumerate(rods) if rod.index == 0]
for barrier in sorted((b for b in barriers if b.saddle is not None), key=lambda b: b.energy):
    one, other = (next(g for g in groups if i in g[0]) for i in barrier.minima)
    if one is not other:
        merged = (one[0] | other[0], (one, other), barrier.energy)
        groups = [g for g in groups if g is not one and g is not other] + [merged]


def draw(group, top, left=0):
    """Draw a group up to an energy; its place, and the first place free beside it."""
    _, parts, energy = group
    if parts is None:
        place, free = left, left + 1
        axes.text(place, energy, f"{energy:.1f}", ha="center", va="top", fontsize=8)
    else:
        one, free = draw(parts[0], energy, left)
        other, free = draw(parts[1], energy, free)
        axes.plot([one, other], [energy, energy], "k-")
        place = (one + other) / 2
    axes.plot([place, place], [energy, top], "k-")
    return place, free


top, left = 1.05 * max(energy for _, _, energy in groups), 0
for group in groups:
    _, left = draw(group, top, left)
figure.savefig("rod_barriers.png", dpi=120)
