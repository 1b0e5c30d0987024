"""Whether a deformed chain is in balance, by formulas that the solver does not use.

Turns are matrices here. The moment μ of a hinge follows from J(u)ᵀ x = K u, where J is the right
Jacobian of the exponential in closed form and u the logarithm by the trace; the solver has the
inverse Jacobian and quaternions. On segment k act μ_k, −μ_k+1 and the force:

    μ_k − μ_k+1 = (R_k v_k) × F
"""

import math

import numpy as np

from loopelastica.rod.kernels.chain import slack
from loopelastica.rod.kernels.jit import kernel
from loopelastica.rod.kernels.linalg import eliminate
from loopelastica.rod.kernels.rotations import cross, larger


@kernel
def _rotation_vector(r):
    """Rotation vector, as three floats, of a matrix (3, 3)."""
    x, y, z = 0.5 * (r[2, 1] - r[1, 2]), 0.5 * (r[0, 2] - r[2, 0]), 0.5 * (r[1, 0] - r[0, 1])
    sine, cosine = math.sqrt(x * x + y * y + z * z), 0.5 * (r[0, 0] + r[1, 1] + r[2, 2] - 1.0)
    factor = math.atan2(sine, cosine) / sine if sine > 1e-12 else 1.0
    return factor * x, factor * y, factor * z


@kernel
def _moment(chain, j, u, system):
    """Solve J(u)ᵀ x = K_j u: x in the last column of ``system`` (3, 4). Returns u·K_j·u/2."""
    t = chain.axes[j]
    along = u[0] * t[0] + u[1] * t[1] + u[2] * t[2]
    a2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    a = math.sqrt(a2)
    if a > 1e-3:
        first, second = 2.0 * (math.sin(0.5 * a) / a) ** 2, (a - math.sin(a)) / (a * a2)
    else:
        first, second = 0.5 - a2 / 24.0, 1.0 / 6.0 - a2 / 120.0
    energy = 0.0
    for i in range(3):
        for k in range(3):
            system[i, k] = second * u[i] * u[k]
        system[i, i] += 1.0 - second * a2
        system[i, 3] = chain.bending[j] * (u[i] - along * t[i]) + chain.torsion[j] * along * t[i]
        energy += 0.5 * u[i] * system[i, 3]
    system[0, 1] -= first * u[2]
    system[1, 0] += first * u[2]
    system[0, 2] += first * u[1]
    system[2, 0] -= first * u[1]
    system[1, 2] -= first * u[0]
    system[2, 1] += first * u[0]
    eliminate(system, 3, 3, 4, 0.0)
    for i in range(2, -1, -1):
        for k in range(i + 1, 3):
            system[i, 3] -= system[i, k] * system[k, 3]
        system[i, 3] /= system[i, i]
    return energy


@kernel
def judge(chain, force, position, free_spin, energy, length, end, nodes, rotations, moment):
    """Largest error of a chain as it is given back; NaN if anything is.

    ``nodes`` (m + 1, 3) in units of 1/``length`` and ``rotations`` (m + 1, 3, 3) of the segments
    and the end are what is given back, ``end`` (3, 3) the end frame of the rest shape.
    ``moment`` (3,) becomes that at the start. The error is the largest of: the end's place;
    moments that are not balanced, relative to the largest load or a turn of 1e-5 rad in the
    stiffest hinge; the energy, relative to itself.
    """
    m = chain.steps.shape[0]
    before, turned, last = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    u, mu, system = np.empty(3), np.empty(3), np.empty((3, 4))
    for i in range(3):
        for k in range(3):
            last[i, k] = 0.0
            for j in range(3):
                last[i, k] += rotations[m, i, j] * end[k, j]
    size = slack(chain) + math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    worst, total, spin = 0.0, 0.0, 0.0
    for j in range(m + 1):
        here = rotations[j] if j < m else last
        for i in range(3):
            for k in range(3):
                if j == 0:
                    turned[i, k] = here[i, k]
                else:
                    turned[i, k] = 0.0
                    for a in range(3):
                        turned[i, k] += rotations[j - 1, a, i] * here[a, k]
        u[0], u[1], u[2] = _rotation_vector(turned)
        total += _moment(chain, j, u, system)
        for i in range(3):
            mu[i] = 0.0
            for k in range(3):
                mu[i] += here[i, k] * system[k, 3]
            size = larger(size, abs(mu[i]))
        if j == 0:
            for i in range(3):
                moment[i] = mu[i]
        else:
            x = (nodes[j, 0] - nodes[j - 1, 0]) / length
            y = (nodes[j, 1] - nodes[j - 1, 1]) / length
            z = (nodes[j, 2] - nodes[j - 1, 2]) / length
            tx, ty, tz = cross(x, y, z, force[0], force[1], force[2])
            worst = larger(worst, abs(before[0] - mu[0] - tx))
            worst = larger(worst, abs(before[1] - mu[1] - ty))
            worst = larger(worst, abs(before[2] - mu[2] - tz))
        for i in range(3):
            before[i] = mu[i]
            if j == m and free_spin:
                spin += mu[i] * rotations[m, i, 2]
    worst = larger(worst, abs(spin)) / size
    worst = larger(worst, abs(total - energy) / (1.0 + total))
    for i in range(3):
        worst = larger(worst, abs(nodes[m, i] / length - position[i]))
    return worst
