"""
Twist until it snaps
====================

Hold a cable with some slack between your hands and turn one end: it stays calm for some turns,
bulges, and suddenly throws a loop. ``le.twist_end`` follows the rod while its end is turned, past
the place where somebody who turns it by hand loses it, and says where that is.
"""

# %%
# Cables with some slack
# ----------------------
# Both ends are clamped along one line, 1 − slack rod lengths apart.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb

import loopelastica as le

SLACKS = (0.2, 0.3, 0.4, 0.5)


def cable(slack):
    return le.solve(le.Clamping([0.0, 0.0, 1.0 - slack], np.eye(3)))


# %%
# A closed form
# -------------
# In a long rod the slack gathers in one loop, which is known in closed form: under a tension T and
# a twisting moment M it takes up a length S = 4 √(K0/T) √(1 − m²), with m = M/(2 √(K0 T)), and the
# end has been turned by R = M L/K3 + 4 arccos m (radians). Given S, this R has a maximum, at
# m² = ½ − S K3/(4 K0 L): no such loop is beyond it, and the rod must snap. The less slack there is,
# the better this holds.


def closed_form(slack, torsion_ratio=1.0):
    m = np.sqrt(0.5 - 0.25 * slack * torsion_ratio)
    wound = 8.0 * m * np.sqrt(1.0 - m**2) / (slack * torsion_ratio)
    return (wound + 4.0 * np.arccos(m)) / (2.0 * np.pi)


# %%
# Turn the ends
# -------------
# Stability is lost at a fold, where the branch turns back. What the rod falls to from there is
# where the unstable direction just behind the fold leads, ``le.ways_down``. The ideal rod has no
# thickness; it throws a loop, passes through itself, and has two turns fewer.

paths, snapped = {}, {}
print("slack  snaps at  long rod  energy there  after it  turns shed")
for slack in SLACKS:
    path = paths[slack] = le.twist_end(cable(slack), closed_form(slack))
    # the first rods behind the fold are still flat: take one a little further
    saddle = path.rods[2 + next(k for k, rod in enumerate(path.rods) if rod.index == 1)]
    below = snapped[slack] = min(le.ways_down(saddle), key=lambda rod: rod.energy)
    shed = saddle.net_winding - below.net_winding
    print(
        f"{slack:4.1f} {path.snaps_at:9.4f} {closed_form(slack):9.4f} {saddle.energy:10.1f}"
        f" {below.energy:12.1f} {shed:8.1f}"
    )

# %%
# The threshold for more amounts of slack, beside that of the long rod.

more = np.array([0.17, 0.18, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5])
snaps = np.array([le.twist_end(cable(s), closed_form(s)).snaps_at for s in more], dtype=float)
for slack, found in zip(more, snaps, strict=True):
    print(f"slack {slack:.2f}: {found:.4f}, {100 * (1 - found / closed_form(slack)):.2f} % less")

# %%
# A picture
# ---------
# The twisting moment and the energy while the end is turned; broken lines are the branch behind the
# fold, which no hand can follow. Arrows lead to where each rod snaps to. Below, a rod with a slack
# of 0.3 on its way.


COLOURS = ("#0072B2", "#009E73", "#E69F00", "#CC79A7")
figure = plt.figure(figsize=(10.4, 6.4))
moment = figure.add_axes((0.07, 0.47, 0.25, 0.43))
energy = figure.add_axes((0.4, 0.47, 0.25, 0.43))
threshold = figure.add_axes((0.73, 0.47, 0.25, 0.43))
for slack, colour in zip(SLACKS, COLOURS, strict=True):
    path = paths[slack]
    fold = next(k for k, rod in enumerate(path.rods) if rod.index == 1)
    for axes, value in ((moment, lambda rod: rod.loads[5]), (energy, lambda rod: rod.energy)):
        values = [value(rod) for rod in path.rods]
        axes.plot(path.parameter[:fold], values[:fold], color=colour, lw=2.2, label=f"{slack}")
        axes.plot(path.parameter[fold - 1 :], values[fold - 1 :], color=colour, lw=1, ls="--")
        axes.plot(path.snaps_at, values[fold], "*", color=colour, ms=13, mec="k", mew=0.6)
        goal = (path.snaps_at, value(snapped[slack]))
        axes.annotate("", goal, (path.snaps_at, values[fold]),
                      arrowprops={"arrowstyle": "->", "color": colour})  # fmt: skip
moment.set_ylabel("twisting moment M3 (K0/L)")
energy.set_ylabel("energy (K0/L)")
for axes in (moment, energy):
    axes.set_xlabel("turns of the end")
    axes.set_xlim(0, 4)
energy.set_ylim(bottom=0)
moment.set_ylim(bottom=-2)
fine = np.linspace(0.14, 0.52, 100)
threshold.plot(fine, closed_form(fine), color="0.5", lw=1.5, label="one loop in a long rod")
threshold.plot(more, snaps, "*", color="k", ms=11, label="found")
threshold.set_xlabel("slack (L)")
threshold.set_ylabel("turns at which it snaps")
threshold.set_ylim(bottom=0)
threshold.legend(frameon=False, loc="lower left")
figure.legend(*moment.get_legend_handles_labels(), title="slack (L); ★ it snaps", ncols=4,
              frameon=False, loc="upper left", bbox_to_anchor=(0.06, 1.0))  # fmt: skip

light = np.array([0.3, -0.6, 0.74])


def draw(axes, rod, colour, radius=0.016, n=240):
    """Draw a tube with two stripes that follow the frame."""
    line, frames = rod.centerline(n), rod.frames(n)
    # the rod may be turned about the line of its ends at no cost: bring its bulge to the front
    bulge = line[np.argmax(np.hypot(*line[:, :2].T))]
    c, s = np.array([bulge[0], -bulge[1]]) / max(np.hypot(*bulge[:2]), 1e-9)
    view = np.array([[0.0, 0.0, 1.0], [s, c, 0.0], [c, -s, 0.0]])
    angle = np.linspace(0.0, 2.0 * np.pi, 25)
    outward = np.einsum("nik,kj->nji", frames[:, :, :2], [np.cos(angle), np.sin(angle)]) @ view.T
    faces = np.tile(to_rgb(colour), (n, 25, 1))
    faces[:, :5] = faces[:, 12:17] = 1.0
    faces *= 0.7 + 0.3 * (outward @ light)[:, :, None]
    surface = np.moveaxis((line @ view.T)[:, None] + radius * outward, -1, 0)
    axes.plot_surface(*surface, facecolors=faces, rstride=1, cstride=1, shade=False, lw=0)
    for clamp in ((-0.08, 0.0), (line[-1, 2], line[-1, 2] + 0.08)):
        axes.plot(clamp, (0, 0), (0, 0), color="0.4", lw=6, solid_capstyle="butt")
    axes.set_axis_off()
    axes.view_init(15, -90)
    axes.set_xlim(0.0, 0.7)
    axes.set_ylim(-0.35, 0.35)
    axes.set_zlim(-0.25, 0.45)
    axes.set_box_aspect((1, 1, 1), zoom=1.6)


path = paths[0.3]
fold = next(k for k, rod in enumerate(path.rods) if rod.index == 1)
chosen = [int(np.argmin(abs(path.parameter[:fold] - t))) for t in (0.0, 1.0, 2.0)]
shown = [(path.rods[k], f"{path.parameter[k]:.1f} turns") for k in chosen]
shown += [
    (path.rods[fold - 1], f"{path.snaps_at:.2f} turns: it snaps …"),
    (snapped[0.3], "… to this"),
]
for k, (rod, title) in enumerate(shown):
    axes = figure.add_axes((0.01 + 0.197 * k, -0.02, 0.19, 0.34), projection="3d")
    draw(axes, rod, COLOURS[1])
    axes.set_title(title, fontsize=10, y=0.98)
figure.savefig("twist_until_it_snaps.png", dpi=120)
