import numpy as np
import pytest
from strand import NAMES, added, pdb_lines, place_of

from loopelastica.errors import StructureError
from loopelastica.report.changes import AddedResidue, Changes, Removed
from loopelastica.report.compose_pdb import compose_pdb
from loopelastica.report.placing import Row, plan_for, renumbered


def _rows(*residues):
    """Rows of residues: (number, resname, names)."""
    return [
        Row(0, ("A", number, ""), resname, name, "", "A", "A")
        for number, resname, names in residues
        for name in names
    ]


def _plan(rows, **changes):
    return plan_for(rows, lambda row: (float(row), 0.0, 0.0), Changes(**changes))


def test_the_order_in_which_changes_are_named_does_not_matter():
    text = "\n".join(pdb_lines([1, 2, 6]))
    gap = [added(k, k - 1) for k in (3, 4, 5)]
    texts = {
        compose_pdb(text, Changes(added=tuple(gap[k] for k in order)))
        for order in ((0, 1, 2), (2, 1, 0), (1, 2, 0))
    }
    assert len(texts) == 1


def test_a_chain_may_begin_with_an_added_nucleotide():
    text = "\n".join([*pdb_lines([9], chain="B"), "TER", *pdb_lines([3, 4], serial=20)])
    gap = (added(2, 1), added(1, None))
    lines = compose_pdb(text, Changes(added=gap)).splitlines()
    n = len(NAMES)
    assert lines[n] == "TER"
    assert [x[22:26].strip() for x in lines[n + 1 :: n]] == ["1", "2", "3", "4"]


def test_purines_and_pyrimidines_have_their_own_order():
    order = {
        "G": "N9 C8 N7 C5 C6 O6 N1 C2 N2 N3 C4",
        "DT": "N1 C2 O2 N3 C4 O4 C5 C7 C6",
    }
    rows = _rows((1, "G", ("P", "C4'")))
    for resname, names in order.items():
        names = ("OP1", *names.split())
        new = added(2, 1)
        for key, value in (
            ("names", names[::-1]),
            ("elements", tuple(name[0] for name in names[::-1])),
            ("resname", resname),
        ):
            object.__setattr__(new, key, value)
        plan = _plan(rows, added=(new,))
        assert [atom.name for atom in plan.after[1]] == list(names)


def test_hydrogens_stay_behind_what_is_completed():
    rows = _rows((1, "U", ("P", "C4'", "H5'", "H6")))
    plan = _plan(rows, added=(added(1, None, names=("O3'", "O5'")),))
    assert {row: [a.name for a in atoms] for row, atoms in plan.after.items()} == {
        0: ["O5'"],
        1: ["O3'"],
    }


def _new(**atoms):
    """Atoms of nucleotide 1 by names, with their elements."""
    return AddedResidue(
        model=0, chain="A", number=1, icode="", resname="2MG", after=None,
        names=tuple(atoms["names"]), elements=tuple(atoms["elements"]),
        positions_A=np.zeros((len(atoms["names"]), 3)),
    )  # fmt: skip


def test_added_hydrogens_come_behind_all_heavy_atoms():
    rows = _rows((1, "2MG", ("P", "C4'", "N1", "CM2")))
    plan = _plan(rows, added=(_new(names=("H1'", "O5'", "HN1"), elements="HOH"),))
    assert {row: [a.name for a in atoms] for row, atoms in plan.after.items()} == {
        0: ["O5'"],
        3: ["H1'", "HN1"],
    }


def test_an_atom_may_be_left_out_and_another_added_by_its_name():
    rows = _rows((1, "2MG", ("P", "O5'", "HO5'")))
    removed = Removed(0, "A", 1, "", "2MG", "HO5'")
    plan = _plan(rows, added=(_new(names=("HO5'",), elements="H"),), removed=(removed,))
    assert plan.gone == {2}
    assert [a.name for a in plan.new] == ["HO5'"]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"added": (added(7, 6),)}, r"A\.U7: model 1 has no A\.6, which it is to follow"),
        (
            {"added": (added(7, 6, model=1),)},
            r"A\.U7: model 2 has no A\.6, which it is to follow",
        ),
        (
            {"added": (added(7, 8), added(8, 7))},
            r"A\.U7: it is to follow A\.8, which is neither in the file nor",
        ),
        (
            {"added": (added(7, None, chain="Q"),)},
            r"Q\.U7: model 1 has no chain 'Q' that it could begin",
        ),
        (
            {"added": (added(1, None, names=("P",)),)},
            r"A\.U1: the file has its atom P, which can therefore not be added",
        ),
        (
            {"moved": {(0, "A", 1, "", "C9"): (0.0, 0.0, 0.0)}},
            r"A\.1: model 1 has no atom C9 there that could be moved",
        ),
        (
            {"removed": (Removed(0, "A", 1, "", "HOH"),)},
            r"A\.HOH1: model 1 has no such residue or atom that could be left out",
        ),
    ],
)
def test_what_does_not_fit_the_file_is_a_sentence(changes, sentence):
    with pytest.raises(StructureError, match=sentence):
        _plan(_rows((1, "U", NAMES), (2, "U", NAMES)), **changes)


def test_a_moved_atom_goes_by_the_name_of_today():
    rows = _rows((1, "U", ("O1P", "C5*")))
    plan = _plan(rows, moved={(0, "A", 1, "", "C5'"): place_of(3, "P")})
    assert plan.moved == {1: place_of(3, "P")}


def test_numbers_keep_to_a_floor():
    assert renumbered([1, 2, 7], {2: 4}, 0) == [1, 4, 7]
    assert renumbered([None, None, 3], {}, 2) == [3, 4, 5]
