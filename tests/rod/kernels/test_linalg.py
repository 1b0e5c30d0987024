import numpy as np
import pytest

from loopelastica.rod.kernels.linalg import (
    copy,
    copy_rows,
    eliminate,
    inverse3,
    negative_eigenvalues,
    solve_deficient,
)


def test_elimination_gives_determinant_and_solution(rng):
    for n in (2, 5, 6):
        a, b = rng.normal(size=(n, n)), rng.normal(size=n)
        work = np.column_stack([a, b])
        sign = eliminate(work, n, n, n + 1, 0.0)
        assert sign * np.prod(np.diag(work)) == pytest.approx(np.linalg.det(a), rel=1e-10)
        upper = np.triu(work[:, :n])
        np.testing.assert_allclose(
            np.linalg.solve(upper, work[:, n]), np.linalg.solve(a, b), rtol=1e-8
        )


def test_elimination_of_some_columns_leaves_the_schur_complement(rng):
    # diagonally dominant in the first columns: no row of the second half becomes a pivot
    a = rng.normal(size=(6, 6))
    a[:3, :3] += 50 * np.eye(3)
    work = a.copy()
    assert eliminate(work, 6, 3, 6, 0.0) == 1
    schur = a[3:, 3:] - a[3:, :3] @ np.linalg.solve(a[:3, :3], a[:3, 3:])
    np.testing.assert_allclose(work[3:, 3:], schur, rtol=1e-10)


def test_elimination_stops_at_a_pivot_that_is_too_small():
    for least, sign in ((1e-3, 1.0), (0.5, 0.0)):
        assert eliminate(np.diag([1.0, 0.5]), 2, 2, 2, least) == sign
    assert eliminate(np.array([[0.0, 2.0], [3.0, 1.0]]), 2, 2, 2, 0.0) == -1
    assert eliminate(np.full((2, 2), np.nan), 2, 2, 2, 0.0) == 0


@pytest.mark.parametrize("rank", [4, 6])
def test_a_consistent_system_is_solved_whatever_its_rank(rng, rank):
    a = rng.normal(size=(8, rank)) @ rng.normal(size=(rank, 6))
    right = a @ rng.normal(size=(6, 2))
    x = np.empty((2, 6))
    assert solve_deficient(np.hstack([a, right]), 8, 6, 2, 1e-10, x) == rank
    np.testing.assert_allclose(a @ x.T, right, atol=1e-9)
    # directions without a pivot stay put
    assert np.count_nonzero(np.abs(x[0]) > 0) == rank


def test_negative_eigenvalues_are_numpys(rng):
    seen = set()
    for _ in range(200):
        a, shift = rng.normal(size=(3, 3)), rng.normal()
        a += a.T
        count, det = negative_eigenvalues(a, shift)
        shifted = a + shift * np.eye(3)
        assert count == np.count_nonzero(np.linalg.eigvalsh(shifted) < 0)
        assert det == pytest.approx(np.linalg.det(shifted), rel=1e-9, abs=1e-12)
        seen.add(count)
    assert seen == {0, 1, 2, 3}


def test_the_inverse_of_a_symmetric_matrix_is_numpys(rng):
    a, out = rng.normal(size=(3, 3)), np.empty((3, 3))
    a += a.T + 5 * np.eye(3)
    inverse3(a, out)
    np.testing.assert_allclose(out, np.linalg.inv(a), rtol=1e-9)
    inverse3(np.zeros((3, 3)), out)
    assert not np.isnan(out).any()


def test_copies_go_to_the_start_of_longer_arrays():
    row, rows = np.zeros(4), np.zeros((3, 3))
    copy(np.array([1.0, 2.0]), row)
    copy_rows(np.ones((2, 3)), rows)
    np.testing.assert_array_equal(row, [1, 2, 0, 0])
    np.testing.assert_array_equal(rows, [[1, 1, 1], [1, 1, 1], [0, 0, 0]])
