"""
Error against run time
======================

Thirty clampings, four ways to find an equilibrium: ``le.solve`` and ``le.solve_batch``, and what
one would write with SciPy, collocation (``solve_bvp``) and shooting (``least_squares``). All get
the same targets, and one independent integration judges them all. So few targets show orders of
magnitude; ``loopelastica bench accuracy --full`` measures thousands, and more methods.
"""

# %%
# Targets
# -------
# The end anywhere within 0.95 rod lengths of the start, its frame turned at random.

import itertools
import time

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import loopelastica as le

N = 30
rng = np.random.default_rng(1)
direction = rng.normal(size=(N, 3))
direction /= np.linalg.norm(direction, axis=1)[:, None]
positions = 0.95 * rng.uniform(size=(N, 1)) ** (1 / 3) * direction
rotations = Rotation.random(N, random_state=rng).as_matrix()

# %%
# The rod's equations
# -------------------
# With L = K0 = K3 = 1 the tangent is the derivative of the place, the frame turns with the moment
# M, and M changes with F × t; the force F is constant. Frames are quaternions (w, x, y, z).

START = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]


def slope(_, state, force):
    # plain floats are faster where there is one point; collocation has many
    _, _, _, w, x, y, z, mx, my, mz = state.tolist() if state.ndim == 1 else state
    fx, fy, fz = force
    tx, ty, tz = 2 * (x * z + w * y), 2 * (y * z - w * x), w * w + z * z - x * x - y * y
    return [
        tx, ty, tz,
        -(mx * x + my * y + mz * z) / 2, (mx * w + my * z - mz * y) / 2,
        (my * w + mz * x - mx * z) / 2, (mz * w + mx * y - my * x) / 2,
        fy * tz - fz * ty, fz * tx - fx * tz, fx * ty - fy * tx,
    ]  # fmt: skip


def rod(loads, rtol, at=None):
    """Poses (m, 7) of the rod with some loads (F, M at the start): at arc lengths, or the end's."""
    state, force = [*START, *loads[3:]], (loads[:3].tolist(),)
    found = solve_ivp(
        slope, (0.0, 1.0), state, "DOP853", at, args=force, rtol=rtol, atol=0.1 * rtol
    )
    return found.y[:7].T if at is not None else found.y[:7, -1:].T


def apart(pose, other):
    """Difference (6,) of two poses: of place, and the rotation vector between the frames."""
    one, two = (Rotation.from_quat(p[3:], scalar_first=True) for p in (pose, other))
    return np.concatenate([pose[:3] - other[:3], (one * two.inv()).as_rotvec()])


def target(k):
    quaternion = Rotation.from_matrix(rotations[k]).as_quat(scalar_first=True)
    return np.concatenate([positions[k], quaternion])


# %%
# The judge
# ---------
# Each result is a set of loads and the poses of 17 sections. From each section the rod is
# integrated to the next; the error is the largest jump, of the end against the target too. From the
# start alone a tense rod cannot be integrated to its end: errors grow like exp √F.

SECTIONS = np.linspace(0.0, 1.0, 17)


def error(k, loads, poses):
    jumps = [apart(poses[0], START), apart(poses[-1], target(k))]
    force = loads[:3]
    for here, there in itertools.pairwise(poses):
        moment = loads[3:] + np.cross(force, here[:3])
        q = here[3:] / np.linalg.norm(here[3:])
        state, args = [*here[:3], *q, *moment], (force.tolist(),)
        found = solve_ivp(
            slope, (0.0, SECTIONS[1]), state, "DOP853", args=args, rtol=1e-11, atol=1e-13
        )
        jumps.append(apart(found.y[:7, -1], there))
    return np.abs(jumps).max()


# %%
# Four ways to solve it
# ---------------------
# Shooting starts from no loads. Collocation starts from a cubic with the right ends, frames carried
# along it and the missing twist spread evenly, as a competent user would do; without that it fails
# far more often. Neither is given a second guess.


def by_shooting(k):
    goal = target(k)
    found = least_squares(lambda f: apart(rod(f, 1e-8)[0], goal), np.zeros(6), max_nfev=20)
    return found.x, rod(found.x, 1e-8, SECTIONS)


def cubic(k, s):
    """States (10, m) along the cubic to a target."""
    goal, t = positions[k][:, None], rotations[k][:, 2:]
    start = np.array([[0.0], [0.0], [1.0]])
    line = (3 - 2 * s) * s**2 * goal + (1 - s) ** 2 * s * start - (1 - s) * s**2 * t
    tangent = 6 * s * (1 - s) * goal + (1 - s) * (1 - 3 * s) * start + (3 * s - 2) * s * t
    tangent = (tangent / np.linalg.norm(tangent, axis=0)).T
    frames = [Rotation.identity()]
    for here, there in itertools.pairwise(tangent):
        axis = np.cross(here, there)
        angle = np.arctan2(np.linalg.norm(axis), here @ there)
        axis /= max(np.linalg.norm(axis), 1e-12)
        frames.append(Rotation.from_rotvec(angle * axis) * frames[-1])
    left = (frames[-1].inv() * Rotation.from_matrix(rotations[k])).as_matrix()
    twist = np.arctan2(left[1, 0], left[0, 0])
    frames = Rotation.concatenate(frames) * Rotation.from_rotvec(np.outer(twist * s, [0, 0, 1]))
    q = frames.as_quat(scalar_first=True)
    q[1:] *= np.cumprod(np.sign((q[1:] * q[:-1]).sum(axis=1)))[:, None]
    moment = (frames[1:] * frames[:-1].inv()).as_rotvec() / np.diff(s)[:, None]
    return np.vstack([line, q.T, np.vstack([moment[:1], moment]).T])


def by_collocation(k):
    s = np.linspace(0.0, 1.0, 21)
    guess = cubic(k, s)
    w, *v = guess[3:7, -1]

    def ends(a, b, _):
        # the vector part of the end's quaternion times the inverse of the target's
        off = w * b[4:7] - b[3] * np.array(v) - np.cross(b[4:7], v)
        return np.concatenate([a[:7] - START, b[:3] - positions[k], off])

    with np.errstate(all="ignore"):
        found = solve_bvp(
            lambda *given: np.array(slope(*given)), ends, s, guess, np.zeros(3),
            tol=1e-6, max_nodes=500,
        )  # fmt: skip
    return np.concatenate([found.p, found.y[7:, 0]]), found.sol(SECTIONS)[:7].T


def by_solve(k):
    found = le.solve(le.Clamping(positions[k], rotations[k]))
    return found.loads, found.poses(SECTIONS)


def by_batch(lowest):
    return le.solve_batch(positions, rotations, lowest=lowest)


# %%
# Measure
# -------
# Processor time of one core, after a first call that loads the compiled code; of a batch its mean.
# A result counts as solved if its error is below 1e-5. All clampings have a solution, for the
# energy has a minimum.

results = {}


def report(name, times, found):
    errors = np.array([error(k, *one) for k, one in enumerate(found)])
    results[name] = np.array(times), errors
    solved = errors < 1e-5
    print(f"{name:30}{solved.sum():3} of {N}{np.median(errors[solved]):13.0e}"
          f"{1e3 * np.median(times):11.2f} ms")  # fmt: skip


print("method                         solved   median error  time")
for name, lowest in (("solve_batch, any equilibrium", False), ("solve_batch, the lowest", True)):
    by_batch(lowest)
    began = time.process_time()
    batch = by_batch(lowest)
    spent = (time.process_time() - began) / N
    report(name, np.full(N, spent), [(batch[k].loads, batch[k].poses(SECTIONS)) for k in range(N)])
for name, method in (
    ("solve, the lowest", by_solve),
    ("SciPy solve_bvp", by_collocation),
    ("SciPy least_squares", by_shooting),
):
    times, found = [], []
    for k in range(N):
        began = time.process_time()
        found.append(method(k))
        times.append(time.process_time() - began)
    report(name, times, found)

# %%
# A picture
# ---------
# Each small mark is a target, each large one the median of those that were solved. Marks above the
# line are not solved.

figure, axes = plt.subplots(figsize=(8.6, 5.2), layout="constrained")
axes.axhspan(1e-5, 1e2, color="0.93", lw=0)
axes.text(1.3e-5, 2.0, "not solved", color="0.4")
looks = (("#0072B2", "D"), ("#56B4E9", "D"), ("#009E73", "o"), ("#E69F00", "^"), ("#D55E00", "v"))
for (name, (times, errors)), (colour, marker) in zip(results.items(), looks, strict=True):
    solved = errors < 1e-5
    style = {"color": colour, "marker": marker, "ls": ""}
    axes.plot(times, errors, ms=5, alpha=0.4, mec="none", **style)
    axes.plot(np.median(times[solved]), np.median(errors[solved]), ms=13, mec="k", **style,
              label=f"{name}: {solved.sum()} of {N}")  # fmt: skip
axes.set(xscale="log", yscale="log", xlim=(1e-5, 10), ylim=(1e-14, 10))
axes.set_xlabel("processor time for a target (s)")
axes.set_ylabel("error (L, radian)")
figure.legend(loc="outside lower center", ncols=2, frameon=False)
figure.savefig("error_against_time.png", dpi=120)
