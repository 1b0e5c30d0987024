import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from loopelastica.errors import StructureError
from loopelastica.nanostructures.oxdna.configuration import (
    frame_header,
    nucleotide_lines,
    parse_configuration,
)

HEADER = "t = 100\nb = 20 21 22\nE = -1.4 -1.5 0.1\n"
ROW = "1 2 3 1 0 0 0 0 1"
FAST = ROW + " 0.1 0.2 0.3 0.4 0.5 0.6"


def frame(*rows, header=HEADER):
    return header + "".join(row + "\n" for row in rows)


def test_a_frame_is_read():
    conf = parse_configuration("a.dat", frame(ROW, "4 5 6 0 1 0 0 0 -1"), 2)
    np.testing.assert_array_equal(conf.centre, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(conf.a1, [[1, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(conf.a3, [[0, 0, 1], [0, 0, -1]])
    np.testing.assert_array_equal(conf.box, [20, 21, 22])
    assert conf.header == tuple(HEADER.splitlines())
    assert conf.lines == (ROW, "4 5 6 0 1 0 0 0 -1")


def test_velocities_may_be_there_or_not():
    for row in (ROW, FAST):
        assert parse_configuration("a.dat", frame(row), 1).lines == (row,)


def test_the_last_frame_is_read():
    conf = parse_configuration("a.dat", frame(ROW) + frame("7 8 9 1 0 0 0 0 1"), 1)
    np.testing.assert_array_equal(conf.centre, [[7, 8, 9]])
    assert (conf.frame, conf.n_frames) == (2, 2)


@pytest.mark.parametrize(
    "rest", ["t = 200\n", "t = 200\nb = 20 21 22\n", frame(ROW), frame(ROW, "7 8 9 1 0")]
)
def test_an_incomplete_frame_at_the_end_is_passed_over(rest):
    conf = parse_configuration("a.dat", frame(ROW, "4 5 6 1 0 0 0 0 1") + rest, 2)
    assert (conf.frame, conf.n_frames) == (1, 2)
    np.testing.assert_array_equal(conf.centre[1], [4, 5, 6])


def test_axes_of_few_digits_are_made_orthonormal(rng):
    turn = Rotation.random(50, rng=rng).as_matrix()
    rows = np.concatenate([rng.normal(size=(50, 3)), turn[:, :, 0], turn[:, :, 2]], axis=1)
    text = frame(*(" ".join(f"{x:.3f}" for x in row) for row in rows.tolist()))
    conf = parse_configuration("a.dat", text, 50)
    for left, right, product in (
        (conf.a1, conf.a1, 1),
        (conf.a3, conf.a3, 1),
        (conf.a1, conf.a3, 0),
    ):
        np.testing.assert_allclose(np.einsum("ij,ij->i", left, right), product, atol=1e-12)
    np.testing.assert_allclose(conf.a1, turn[:, :, 0], atol=2e-3)


def test_what_is_written_is_read_again(rng):
    turn = Rotation.random(9, rng=rng).as_matrix()
    centre, a1, a3 = 1e3 * rng.normal(size=(9, 3)), turn[:, :, 0], turn[:, :, 2]
    lines = [*frame_header(np.array([40.0, 41.0, 42.5])), *nucleotide_lines(centre, a1, a3)]
    conf = parse_configuration("a.dat", "\n".join(lines), 9)
    np.testing.assert_allclose(conf.centre, centre, rtol=1e-11)
    np.testing.assert_allclose(conf.a1, a1, atol=1e-11)
    np.testing.assert_allclose(conf.a3, a3, atol=1e-11)
    np.testing.assert_array_equal(conf.box, [40.0, 41.0, 42.5])
    assert {len(line.split()) for line in conf.lines} == {15}


def test_a_nucleotide_that_moves_keeps_its_velocities():
    x = np.array([[1.5, 0, 0]]), np.array([[1.0, 0, 0]]), np.array([[0, 0, 1.0]])
    assert nucleotide_lines(*x, [FAST]) == ["1.5 0 0 1 0 0 0 0 1 0.1 0.2 0.3 0.4 0.5 0.6"]
    assert nucleotide_lines(*x, [ROW]) == ["1.5 0 0 1 0 0 0 0 1"]


REFUSED = {
    "nothing": ("\n", "no oxDNA configuration"),
    "a topology": ("2 1\n1 A -1 1\n", "no oxDNA configuration"),
    "too few": (frame(ROW), "lines of 1 nucleotides, but the topology has 2"),
    "too many": (frame(ROW, ROW, ROW), "lines of 3 nucleotides, but the topology has 2"),
    "both frames": (frame(ROW) + frame(ROW), "frame 1 of a.dat"),
    "too many last": (frame(ROW, ROW) + frame(ROW, ROW, ROW), "frame 2 of a.dat"),
    "only a header": ("t = 0\n", "three sides of a box"),
    "box": (frame(ROW, ROW, header="t = 0\nb = 20 20\nE = 0 0 0\n"), "line 2.*three sides"),
    "flat box": (frame(ROW, ROW, header="t = 0\nb = 0 9 9\nE = 0 0 0\n"), "line 2"),
    "narrow box": (frame(ROW, ROW, header="t = 0\nb = 9 1e-320 9\nE = 0 0 0\n"), "line 2"),
    "box of nothing": (frame(ROW, ROW, header="t = 0\nb = nan 9 9\nE = 0 0 0\n"), "line 2"),
    "energy": (frame(ROW, ROW, header="t = 0\nb = 9 9 9\n1 2 3\n"), "line 3"),
    "columns": (frame(ROW, ROW + " 1"), "line 5: nucleotide 1 has 10 numbers"),
    "mixed": (frame(ROW, FAST), "line 5: nucleotide 1 has 15 numbers"),
    "word": (frame(ROW, ROW.replace("2", "two")), "line 5: 'two' of nucleotide 1"),
    "nan": (frame(ROW, ROW.replace("2", "nan")), "line 5: 'nan' of nucleotide 1"),
    "infinite": (frame(ROW, ROW.replace("2", "1e999")), "line 5: '1e999' of nucleotide 1"),
    "too far": (frame(ROW, ROW.replace("2", "-1e300")), "line 5: '-1e300' of nucleotide 1"),
    "not ascii": (frame(ROW, ROW.replace("2", "٢")), "line 5: '٢' of nucleotide 1"),
    "empty line": (frame(ROW, "", ROW), "lines of 3 nucleotides"),
    "length": (frame(ROW, "1 2 3 0.9 0 0 0 0 1"), "axes of nucleotide 1 have lengths 0.9 and 1"),
    "zero": (frame(ROW, "1 2 3 0 0 0 0 0 1"), "axes of nucleotide 1"),
    "lean": (frame(ROW, "1 2 3 1 0 0 0.6 0 0.8"), "product 0.6"),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_a_damaged_configuration_is_refused_in_one_sentence(fault):
    text, says = REFUSED[fault]
    with pytest.raises(StructureError, match=says) as refusal:
        parse_configuration("a.dat", text, 2)
    assert "a.dat" in str(refusal.value)
    assert "\n" not in str(refusal.value)
