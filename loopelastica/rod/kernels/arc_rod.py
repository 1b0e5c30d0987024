"""The rod of circular arcs: its energy, and exact derivatives in its tangents.

n arcs of lengths l_k lie between unit tangents u_k and u_k+1; u_0 and u_n are the clamps, the
others are free. Neighbours share a tangent, so the curve is smooth and its arc length exact, and
it ends where the sum of its chords does. With z = 1 − u·v = 1 − cos θ for the two tangents u, v of
an arc

    S = θ/sin θ = Σ k! zᵏ/(2k + 1)!!,   ψ = tan(θ/2)/θ = 1/(S (2 − z))
    bending energy  θ²/2l, dE/dz = S/l (a little more beyond 2 rad);   chord  d = l ψ (u + v)

Under forces G_k on the chords (dE = Σ G_k·d(d_k)), with γ = G·(u + v), A = S/l + l ψ′ γ and
B = S′/l + l ψ″ γ, the derivatives of θ²/2l + G·d are

    in u            −A v + l ψ G
    in u, u         B v vᵀ − l ψ′ (v Gᵀ + G vᵀ)
    in u, v         B v uᵀ − A 1 − l ψ′ (v Gᵀ + G uᵀ)

and the same with u and v exchanged. On the sphere a Hessian loses u·∇ on its diagonal. Tangent k
moves by u + E x with two coordinates x; the columns of E are orthonormal over √h_k, h_k half of
both neighbouring arcs, so that |x|² is an integral over the rod and meshes do not matter.
"""

import math
from typing import NamedTuple

import numpy as np

from loopelastica._arrays import Array
from loopelastica.rod.kernels.jit import kernel

# z of an arc that turns by 2 rad, from where on it becomes stiffer so that it never turns by half
# a turn, where its chord has no direction; z that is as good as that
SHARP = 1.4161468365471424
_FOLDED = 1.9999


class ArcRod(NamedTuple):
    """A curve of n arcs that begins in the origin."""

    s: Array
    """(n + 1,): arc lengths of the nodes, from 0 to 1."""
    tangents: Array
    """(n + 1, 3)."""
    points: Array
    """(n + 1, 3): the nodes, which follow from the others."""


class Slopes(NamedTuple):
    """First derivatives by the coordinates of tangents; rows 0 and n are not used."""

    basis: Array
    """(n + 1, 3, 2): E."""
    own: Array
    """(n + 1, 3, 2): of a node's own place."""
    after: Array
    """(n + 1, 3, 2): of the places of all nodes after it."""
    bending: Array
    """(2n − 2,): of the bending energy."""


@kernel
def arc(z):
    """E′ l, E″ l of the energy, ψ, ψ′, ψ″ at z = 1 − cos θ."""
    if z < 0.1:
        # k! zᵏ/(2k + 1)!! and its derivatives
        s0, s1, s2, a, power = 1.0, 0.0, 0.0, 1.0, 1.0
        for k in range(1, 14):
            a *= k / (2.0 * k + 1.0)
            if k > 1:
                s2 += k * (k - 1) * a * power
                power *= z
            s1 += k * a * power
            s0 += a * power * z
    else:
        half = math.asin(math.sqrt(0.5 * z))
        across = z * (2.0 - z)
        s0 = 2.0 * half / math.sqrt(across)
        s1 = (1.0 - s0 * (1.0 - z)) / across
        s2 = (s0 - 3.0 * (1.0 - z) * s1) / across
    d0 = s0 * (2.0 - z)
    d1 = s1 * (2.0 - z) - s0
    d2 = s2 * (2.0 - z) - 2.0 * s1
    if z > SHARP:
        # the derivatives of y²/(1 − y) with y = (z − z_sharp)/(2 − z_sharp)
        left = (2.0 - z) / (2.0 - SHARP)
        s0 += (1.0 / (left * left) - 1.0) / (2.0 - SHARP)
        s1 += 2.0 / (left**3 * (2.0 - SHARP) ** 2)
    return s0, s1, 1.0 / d0, -d1 / d0**2, (2.0 * d1 * d1 / d0 - d2) / d0**2


@kernel
def turning(tangents, k):
    """Z = 1 − cos θ of arc ``k``."""
    z = 0.0
    for i in range(3):
        z += 0.5 * (tangents[k + 1, i] - tangents[k, i]) ** 2
    return z


@kernel
def trace(rod):
    """Lay out the nodes; the bending energy, infinite where an arc turns too far."""
    s, u, points = rod.s, rod.tangents, rod.points
    energy = 0.0
    for i in range(3):
        points[0, i] = 0.0
    for k in range(s.shape[0] - 1):
        z, length = turning(u, k), s[k + 1] - s[k]
        if not z < _FOLDED:
            return math.inf
        psi = arc(z)[2]
        half = math.asin(math.sqrt(0.5 * z))
        energy += 2.0 * half * half / length
        if z > SHARP:
            energy += (z - SHARP) ** 2 / ((2.0 - z) * (2.0 - SHARP) * length)
        for i in range(3):
            points[k + 1, i] = points[k, i] + length * psi * (u[k, i] + u[k + 1, i])
    return energy


@kernel
def width(s, k):
    """Half of both arcs at node ``k``."""
    low, high = k - 1 if k > 0 else 0, k + 1 if k + 1 < s.shape[0] else k
    return 0.5 * (s[high] - s[low])


@kernel
def find_slopes(rod, slopes):
    """Fill ``slopes``."""
    s, u, basis, own, after = rod.s, rod.tangents, slopes.basis, slopes.own, slopes.after
    n = s.shape[0] - 1
    for k in range(1, n):
        # across the smallest component of u
        least = 0
        for i in range(1, 3):
            if u[k, i] ** 2 < u[k, least] ** 2:
                least = i
        scale = 1.0 / math.sqrt(width(s, k) * (1.0 - u[k, least] ** 2))
        for i in range(3):
            basis[k, i, 0] = -scale * u[k, least] * u[k, i]
        basis[k, least, 0] += scale
        for i in range(3):
            p, q = (i + 1) % 3, (i + 2) % 3
            basis[k, i, 1] = u[k, p] * basis[k, q, 0] - u[k, q] * basis[k, p, 0]
        for side in range(2):
            slopes.bending[2 * k - 2 + side] = 0.0
            for i in range(3):
                after[k, i, side] = 0.0
    for k in range(n):
        length = s[k + 1] - s[k]
        s0, _, psi, psi1, _ = arc(turning(u, k))
        for end in range(2):
            node, other = k + end, k + 1 - end
            if not 0 < node < n:
                continue
            for side in range(2):
                along = 0.0
                for i in range(3):
                    along += u[other, i] * basis[node, i, side]
                slopes.bending[2 * node - 2 + side] -= s0 / length * along
                for i in range(3):
                    d = psi * basis[node, i, side] - psi1 * (u[k, i] + u[k + 1, i]) * along
                    after[node, i, side] += length * d
                    if end == 1:
                        own[node, i, side] = length * d


@kernel
def add_arcs(rod, forces, basis, hessian):
    """Add to the upper triangle of ``hessian`` what is due to bending and to ``forces`` (n, 3)."""
    s, u = rod.s, rod.tangents
    n = s.shape[0] - 1
    # components of the arc's other tangent and of G across either tangent
    v, g = np.empty((2, 2)), np.empty((2, 2))
    for k in range(n):
        length = s[k + 1] - s[k]
        s0, s1, psi, psi1, psi2 = arc(turning(u, k))
        gamma = 0.0
        for i in range(3):
            gamma += forces[k, i] * (u[k, i] + u[k + 1, i])
        c = length * psi1
        a, b = s0 / length + c * gamma, s1 / length + length * psi2 * gamma
        for end in range(2):
            node, other = k + end, k + 1 - end
            radial = 0.0
            for side in range(2):
                v[end, side] = g[end, side] = 0.0
            for i in range(3):
                radial += u[node, i] * (length * psi * forces[k, i] - a * u[other, i])
                for side in range(2):
                    v[end, side] += u[other, i] * basis[node, i, side]
                    g[end, side] += forces[k, i] * basis[node, i, side]
            if 0 < node < n:
                at, scale = 2 * node - 2, 1.0 / width(s, node)
                for p in range(2):
                    hessian[at + p, at + p] -= radial * scale
                    for q in range(p, 2):
                        hessian[at + p, at + q] += b * v[end, p] * v[end, q] - c * (
                            v[end, p] * g[end, q] + g[end, p] * v[end, q]
                        )
        if 0 < k < n - 1:
            at = 2 * k - 2
            for p in range(2):
                for q in range(2):
                    dot = 0.0
                    for i in range(3):
                        dot += basis[k, i, p] * basis[k + 1, i, q]
                    hessian[at + p, at + 2 + q] += (
                        b * v[0, p] * v[1, q]
                        - a * dot
                        - c * (v[0, p] * g[1, q] + g[0, p] * v[1, q])
                    )


@kernel
def move(rod, basis, x, fraction, moved):
    """Tangents of ``moved``: those of ``rod`` after ``fraction`` of the step ``x`` (2n − 2,)."""
    u, w = rod.tangents, moved.tangents
    for k in range(1, u.shape[0] - 1):
        size = 0.0
        for i in range(3):
            w[k, i] = u[k, i] + fraction * (
                basis[k, i, 0] * x[2 * k - 2] + basis[k, i, 1] * x[2 * k - 1]
            )
            size += w[k, i] ** 2
        for i in range(3):
            w[k, i] /= math.sqrt(size)


@kernel
def largest_turn(s, x):
    """Largest turn of a tangent in the step ``x`` (2n − 2,), to first order, rad."""
    largest = 1e-300
    for k in range(1, s.shape[0] - 1):
        square = (x[2 * k - 2] ** 2 + x[2 * k - 1] ** 2) / width(s, k)
        if not square <= largest:
            largest = square
    return math.sqrt(largest)
