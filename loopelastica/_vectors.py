"""Many vectors at once: their products, their directions."""

import numpy as np

from loopelastica._arrays import Array


def dot(a: Array, b: Array) -> Array:
    """Scalar products (m,) of vectors (m, k) with as many others.

    Examples
    --------
    >>> dot(np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[1.0, 1.0], [0.0, 2.0]])).tolist()
    [3.0, 8.0]
    """
    return np.asarray(np.einsum("ij,ij->i", a, b))


def unit(vectors: Array) -> Array:
    """Vectors (..., k) of length 1; those of length 0 stay.

    Examples
    --------
    >>> unit(np.array([[3.0, 4.0], [0.0, 0.0]])).tolist()
    [[0.6, 0.8], [0.0, 0.0]]
    """
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-9))


def perpendicular(vectors: Array, normals: Array) -> Array:
    """What of vectors (m, k) is perpendicular to as many unit vectors.

    Examples
    --------
    >>> perpendicular(np.array([[3.0, 4.0]]), np.array([[0.0, 1.0]])).tolist()
    [[3.0, 0.0]]
    """
    return vectors - dot(vectors, normals)[:, None] * normals
