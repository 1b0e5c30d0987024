"""The ideal elastic rod: inextensible, unshearable, isotropic, naturally straight.

Everything here is dimensionless: lengths in units of the rod's length L, forces in K0/L², moments
in K0/L, energies in K0/L. A rod of bending rigidity K0 and torsion rigidity K3 = K30·K0 carries a
constant force F and the moment M(s) = M(0) + F × (r(s) − r(0)); its frame turns at the rate of the
curvature, M across the tangent over K0, and of the twist, M3 over K3 (eq. 1–4 of Ameline, Haliyo,
Huang & Cognet, J. Comput. Phys. 373 (2018) 736, doi:10.1016/j.jcp.2018.07.021).

The inverse problem: given where the end is and how it is turned (`Clamping`), find the six loads.
It has many solutions, and they are critical points of ∫ ½(κ² + K30 τ²) ds.

============  ===========================================================================
symbol        meaning
============  ===========================================================================
R             frame of a section in the start frame, columns d1 d2 d3; d3 = t is the tangent
q             clamping parameters (η1 η2 η3 ψ θ φ), ZYZ Euler angles (eq. 6)
f             loads (F, M) at s = 0 in the start frame (eq. 21)
p             physical parameters (λ t_P a φ0 s_ini/μ L/μ) (eq. 14)
K30           torsion ratio K3/K0; it spins the frames and never changes the center line of f
quaternion    (w, x, y, z) of R
============  ===========================================================================

The way from q to rods: `clamping` (q) → `solve`, `batch`, `equilibria` → `equilibrium` (what a rod
says of itself) → `stability`, `morse` (what topology demands of a list); `descent` and `barriers`
say what a saddle separates; `continuation` follows a rod while its clamping moves, by the steps
of `_branch`. What they share is in `_starts`, `_library` (stored guesses) and `_arguments`.

Beneath them, compiled (:mod:`.kernels`; `kernels.jit`: how, and where the code is kept):

- `shooting`, `newton`: f to end pose with its Jacobian; one guess to a solution;
- `multistart`: starts to solutions, through `boundary_layers` (high tension in closed form),
  `minimization` (the `discrete_rod` of least energy) and `multiple_shooting`, each confirmed in
  `refinement`;
- `second_variation`: conjugate points and inertia; `descent`: the gradient flow;
  `arclength`: one step along a branch;
- `closed_form` with `cubic` and `elliptic`: the rod from its physical parameters (`parameters`).

:mod:`.paper` is the method of 2018 as printed: the reference that benchmarks compare with.
"""
