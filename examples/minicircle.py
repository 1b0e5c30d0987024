"""
A minicircle that is wound up
=============================

A closed ring of DNA with more turns than it likes stays a flat circle at first, although it is
twisted. Beyond a critical number of turns the circle gives way and coils up. Both thresholds and
shapes follow from one clamping: the end of the rod meets its start and is turned about the tangent.
"""

# %%
# The ring
# --------
# The ends meet (position 0) with one tangent; the end frame is turned by the excess linking number
# ΔLk, in turns. Bending and twist persistence of DNA are about 50 nm and 75 nm, hence the torsion
# ratio C/A = 1.5. Energies are in A/L: for a ring of 94 base pairs, 32 nm, this is 1.6 kT.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb

import loopelastica as le

RATIO = 1.5
KT = 50.0 / (94 * 0.34)  # A/L in kT


def ring(excess):
    """The clamping of a closed rod whose end is turned by some turns; whole turns do not show."""
    c, s = np.cos(2.0 * np.pi * excess), np.sin(2.0 * np.pi * excess)
    return le.Clamping([0.0, 0.0, 0.0], [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


# %%
# Wind the circle up by hand, and see where it ceases to be stable. E. E. Zajac's threshold (1962)
# is a twist of √3 A/C turns. It is found a thousandth higher: a mode that is softer than the
# stability test resolves on its mesh counts as stable.

circle = le.solve(ring(0.0), RATIO)
path = le.twist_end(circle, 1.5)
print(f"the circle is lost at {path.snaps_at:.4f} turns; √3 A/C is {np.sqrt(3.0) / RATIO:.4f}")

# %%
# Its energy is known, too: 2π² for bending and 2π² ΔLk² C/A for twist.

exact = 2.0 * np.pi**2 * (1.0 + RATIO * path.parameter**2)
worst = max(abs(rod.energy / e - 1.0) for rod, e in zip(path.rods, exact, strict=True))
print(f"energies of {len(path.rods)} circles agree with the closed form to {worst:.0e}")

# %%
# All equilibria of the ring
# --------------------------
# For each clamping ``le.equilibria`` finds circles that differ by whole turns, and a ring that has
# left the plane, which trades twist for writhe. It is a saddle (index 1): the pass over which the
# circle collapses. Nothing keeps an ideal rod from passing through itself, so no coiled ring is
# stable here; in DNA the contact of its two strands takes over where this branch ends, at the
# figure eight.

excess = np.array([1.02, 1.05, 1.08, 1.11, 1.14])
coiled = []
for turns in excess:
    found = le.equilibria(ring(turns), RATIO, energy_max=61.0, rounds=1)
    # a circle turns into itself when it is shifted along itself; a coiled ring does not
    coiled += [rod for rod in found if rod.family_dimension == 2][:1]
eight = next(rod for rod in le.equilibria(ring(0.0), RATIO, 61.0) if rod.family_dimension == 2)
coiled = [eight, *coiled]
excess = np.array([1.0, *excess])

# %%
# Călugăreanu, Fuller and White: linking number = twist + writhe. The twist comes from the moment,
# the linking number from the frames; the writhe is computed here by itself, as Gauss's double
# integral over the curve.


def gauss_writhe(rod, n=600):
    s = (np.arange(n) + 0.5) / n
    r, t = rod.centerline(s), rod.frames(s)[:, :, 2]
    apart = r[:, None] - r[None]
    distance = np.linalg.norm(apart, axis=-1) + np.eye(n)
    integrand = np.einsum("ijk,ijk->ij", np.cross(t[:, None], t[None]), apart) / distance**3
    return integrand.sum() / (4.0 * np.pi * n**2)


print("  ΔLk    twist   writhe    sum     energy  above the circle")
for turns, rod in zip(excess[1:], coiled[1:], strict=True):
    writhe = gauss_writhe(rod)
    higher = rod.energy - 2.0 * np.pi**2 * (1.0 + RATIO * turns**2)
    print(
        f"{turns:6.2f} {rod.twist:8.4f} {writhe:8.4f} {rod.twist + writhe:8.4f}"
        f" {rod.energy:9.3f} {higher:7.2f} A/L, {KT * higher:4.1f} kT"
    )
    assert abs(rod.twist + writhe - turns) < 1e-3

# %%
# A picture
# ---------
# On the left the energy of the circle, its threshold, and the coiled rings that branch off there
# and lead back to the figure eight; on the right the rings, with stripes that show the twist.


BLUE, ORANGE = "#0072B2", "#D55E00"
lost = np.sqrt(3.0) / RATIO
figure = plt.figure(figsize=(10.4, 6.0))
axes = figure.add_axes((0.08, 0.11, 0.46, 0.72))


def of_circle(turns):
    return 2.0 * np.pi**2 * (1.0 + RATIO * turns**2)


stable, beyond = np.linspace(0.8, lost, 60), np.linspace(lost, 1.3, 20)
axes.plot(stable, of_circle(stable), color=BLUE, lw=2.5, label="circle, stable")
axes.plot(beyond, of_circle(beyond), color=BLUE, lw=1.5, ls="--", label="circle, unstable")
points = [rod.energy for rod in coiled]
axes.plot([*excess, lost], [*points, of_circle(lost)], color=ORANGE, lw=1.5, ls="--")
axes.plot(excess, points, "o", color=ORANGE, label="coiled rings found, index 1")
axes.plot(lost, of_circle(lost), "*", color="k", ms=15, label="√3 A/C, the circle gives way")
axes.plot(path.snaps_at, of_circle(path.snaps_at), "o", mfc="none", mec="k", ms=19,
          label="where it was lost, wound by hand")  # fmt: skip
axes.text(0.985, eight.energy, "figure eight", ha="right", va="center", color=ORANGE)
axes.set_xlabel("excess linking number ΔLk (turns)")
axes.set_ylabel("energy (A/L)")
kt = axes.secondary_yaxis("right", functions=(lambda e: KT * e, lambda e: e / KT))
kt.set_ylabel("energy of 94 base pairs (kT)")
axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(-0.05, 1.0), ncols=2, fontsize=9.5)
light = np.array([0.3, -0.6, 0.74])


def draw(axes, rod, colour, radius=0.014, n=300):
    """Draw a tube with two stripes, seen obliquely onto the plane that is nearest to the ring."""
    line, frames = rod.centerline(n), rod.frames(n)
    line = line - line[:-1].mean(axis=0)
    view = np.linalg.svd(line, full_matrices=False)[2]
    view[2] = np.cross(view[0], view[1])
    angle = np.linspace(0.0, 2.0 * np.pi, 25)
    outward = np.einsum("nik,kj->nji", frames[:, :, :2], [np.cos(angle), np.sin(angle)]) @ view.T
    faces = np.tile(to_rgb(colour), (n, 25, 1))
    faces[:, :5] = faces[:, 12:17] = 1.0
    faces *= 0.7 + 0.3 * (outward @ light)[:, :, None]
    surface = np.moveaxis((line @ view.T)[:, None] + radius * outward, -1, 0)
    axes.plot_surface(*surface, facecolors=faces, rstride=1, cstride=1, shade=False, lw=0)
    axes.set_axis_off()
    axes.view_init(40, -70)
    for name in "xyz":
        getattr(axes, f"set_{name}lim")(-0.19, 0.19)
    axes.set_box_aspect((1, 1, 1), zoom=1.5)


shown = [(le.solve(ring(0.1), RATIO), BLUE, "circle at ΔLk 0.10\nTw 0.10")]
for k in (5, 3):
    sum_of = f"Tw {coiled[k].twist:.2f} + Wr {coiled[k].writhe:.2f}"
    shown.append((coiled[k], ORANGE, f"coiled at ΔLk {excess[k]:.2f}\n{sum_of}"))
shown.append((eight, ORANGE, "figure eight\nTw 0, crosses itself"))
for k, (rod, colour, title) in enumerate(shown):
    place = (0.635 + 0.18 * (k % 2), 0.48 - 0.44 * (k // 2), 0.18, 0.36)
    ring_axes = figure.add_axes(place, projection="3d")
    draw(ring_axes, rod, colour)
    ring_axes.set_title(title, fontsize=10, color=colour)
figure.savefig("minicircle.png", dpi=120)
