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

From q to rods: `clamping` (q) → `solve`, `batch`, `equilibria` → `equilibrium` (one rod and its
properties) → `stability`. Paths along a moving clamping: `continuation`, whose steps are in
`_branch`. All of them share `_starts` (tables of starts, records of a solve) and the guess library
of `_library`. Beneath them, compiled (`jit`: what, when and how):

- `shooting`, `newton`: f to end pose with its Jacobian, and one guess to a solution;
- `multistart`: one start to a solution, through `boundary_layers` (high tension in closed form),
  `minimization` (the discrete rod of least energy) and `multiple_shooting`; `refinement` confirms;
- `arclength`: one step along a branch;
- `second_variation`: conjugate points and the Morse index.

The paper's closed form: `parameters` (p, with `closed_form`, `cubic` and `elliptic`) and `writhe`
(eq. 43). Its method as printed is in `paper`: the reference that benchmarks compare with.
"""
