"""All shapes of a clamped elastic rod, without a guess: python examples/rod_equilibria.py"""

# %% The clamping of Fig. 6 of doi:10.1016/j.jcp.2018.07.021: (η1 η2 η3 ψ θ φ)
import numpy as np

import loopelastica as le

clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
rods = le.equilibria(clamping, torsion_ratio=1.0, energy_max=40.0)

# %% A table: energy, loads at the start, turns of twist, and how well each was verified
for rod in rods:
    print(f"{rod.energy:8.4f}  {np.round(rod.loads, 2)}  {rod.twist:6.3f}  {rod.residual:.0e}")

# %% A picture
from matplotlib.figure import Figure  # noqa: E402

figure = Figure(figsize=(5, 5))
axes = figure.add_subplot(projection="3d")
for rod in rods:
    axes.plot(*rod.centerline(101).T, label=f"{rod.energy:.1f}")
axes.legend(title="energy (K0/L)")
axes.set_aspect("equal")
figure.savefig("rod_equilibria.png", dpi=120)
