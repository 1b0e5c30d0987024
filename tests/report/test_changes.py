import numpy as np
import pytest
from strand import added

from loopelastica.report.changes import AddedResidue, Changes, label


def _residue(**more):
    values = {
        "names": ("P", "O5'"),
        "elements": ("P", "O"),
        "positions_A": np.zeros((2, 3)),
        **more,
    }
    return AddedResidue(0, "A", 3, "", "U", ("A", 2, ""), **values)


@pytest.mark.parametrize(
    "fault",
    [
        {"names": ()},
        {"names": ("P", "P")},
        {"elements": ("P",)},
        {"positions_A": np.zeros((3, 2))},
        {"positions_A": np.full((2, 3), np.nan)},
        {"occupancy": np.inf},
        {"b_factor_A2": [1.0, np.nan]},
    ],
)
def test_a_residue_that_could_not_be_written_is_refused(fault):
    with pytest.raises(ValueError, match=r"A\.U3"):
        _residue(**fault)


def test_a_move_to_nowhere_is_refused():
    with pytest.raises(ValueError, match="`moved`"):
        Changes(moved={(0, "A", 3, "", "P"): np.array([0.0, np.nan, 0.0])})


def test_positions_cannot_be_changed_afterwards():
    with pytest.raises(ValueError, match="read-only"):
        _residue().positions_A[0] = 1.0


def test_one_number_serves_all_atoms():
    residue = _residue(occupancy=0.5, b_factor_A2=[1.0, 2.0])
    assert [residue.numbers(k) for k in range(2)] == [(0.5, 1.0), (0.5, 2.0)]


def test_only_what_changes_atoms_or_notes_is_a_change():
    assert not Changes(software=("loopelastica", "1"))
    assert Changes(notes=("x",))
    assert Changes(added=(added(3, 2),))


def test_notes_and_labels_are_one_line_of_ascii():
    assert Changes(notes=("2 Å – …\nü",)).lines == ["2 A - ...\\n?"]
    assert label(("A\n", 3, ""), "U") == "A\\n.U3"
