"""
All equilibria of a clamped rod
===============================

An elastic rod held at both ends has many shapes in which all forces balance, and a solver that
finds one says nothing of the others. ``le.equilibria`` lists them up to an energy, tells which are
stable, and estimates what its search may have missed.
"""

# %%
# A clamping
# ----------
# It is that of Fig. 6 of Ameline et al., J. Comput. Phys. 373 (2018) 736: the end's position in
# units of the rod's length, and the ZYZ Euler angles of its frame.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb

import loopelastica as le

clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
rods = le.equilibria(clamping, torsion_ratio=1.0)

# %%
# A table: the energy ∫ ½(κ² + τ²) ds; the Morse index, which is 0 for a shape that stays and
# otherwise counts the ways in which it gives way; turns of twist and of writhe; the error of the
# solution by a mesh that the solver did not use.

print("energy   index  twist   writhe  residual")
for rod in rods:
    print(
        f"{rod.energy:8.4f}  {rod.index}  {rod.twist:7.3f} {rod.writhe:7.3f}   {rod.residual:.0e}"
    )
print(rods.evidence)

# %%
# Topology demands relations between the numbers of equilibria of each index; a list that breaks
# them lacks one.

print(rods.morse)

# %%
# A picture
# ---------
# The shapes of least energy, stable ones in the upper row. Each is drawn with its frame, a band
# along the rod that shows the twist; all have the same two ends.


shown = [rod for rod in rods if rod.stable][:4] + [rod for rod in rods if not rod.stable][:4]
figure, grid = plt.subplots(2, 4, figsize=(10.5, 6.2), subplot_kw={"projection": "3d"})
light = np.array([0.3, -0.6, 0.74])


def draw(axes, rod, colour, radius=0.022, stripe=3):
    """Draw a tube around the center line, with a white stripe that follows the frame."""
    line, frames = rod.centerline(240), rod.frames(240)
    angle = np.linspace(0.0, 2.0 * np.pi, 25)
    outward = np.einsum("nik,kj->nji", frames[:, :, :2], [np.cos(angle), np.sin(angle)])
    faces = np.tile(to_rgb(colour), (240, 25, 1))
    faces[:, :stripe] = 1.0
    faces *= 0.7 + 0.3 * (outward @ light)[:, :, None]
    surface = np.moveaxis(line[:, None] + radius * outward, -1, 0)
    axes.plot_surface(*surface, facecolors=faces, rstride=1, cstride=1, shade=False, lw=0)
    for end, way in ((0, -1.0), (-1, 1.0)):
        clamp = np.array([line[end], line[end] + 0.1 * way * frames[end, :, 2]])
        axes.plot(*clamp.T, color="0.4", lw=7, solid_capstyle="butt")


for axes, rod in zip(grid.flat, shown, strict=True):
    draw(axes, rod, "#56B4E9" if rod.stable else "#E69F00")
    state = "stable" if rod.stable else f"index {rod.index}"
    axes.set_title(f"{rod.energy:.2f}, {state}", fontsize=11, y=0.98)
    axes.set_axis_off()
    axes.view_init(12, -35)
    for name, middle in zip("xyz", (-0.12, -0.02, 0.27), strict=True):
        getattr(axes, f"set_{name}lim")(middle - 0.36, middle + 0.36)
    axes.set_box_aspect((1, 1, 1), zoom=1.55)
figure.suptitle("Eight shapes between one pair of clamps, with their energy in K0/L", fontsize=12)
figure.subplots_adjust(0, 0, 1, 0.9, 0, 0.08)
figure.savefig("rod_equilibria.png", dpi=120)
