import numpy as np
import pytest
from gemmi import cif
from strand import NAMES, added, cif_text, place_of

from loopelastica.errors import StructureError
from loopelastica.report.compose import AddedResidue, Changes, Removed
from loopelastica.report.compose_cif import compose_cif

N = len(NAMES)


def _new(number, after, model=0, **more):
    """The nucleotide of a number of the file, whose author counts 100 more."""
    made = added(number, None, model=model, **{"chain": "X", **more})
    values = {name: getattr(made, name) for name in AddedResidue.__dataclass_fields__}
    return AddedResidue(**{**values, "number": number + 100, "after": ("X", after + 100, "")})


GAP = Changes(added=(_new(3, 2), _new(4, 3)))


def _block(text, changes=GAP):
    return cif.read_string(compose_cif(text, changes)).sole_block()


def _atoms(text, changes=GAP):
    return _block(text, changes).get_mmcif_category("_atom_site.")


def test_every_column_of_a_new_row_is_filled():
    whole, atoms = (
        cif.read_string(cif_text([1, 2, 3, 4, 5])).sole_block().get_mmcif_category("_atom_site."),
        _atoms(cif_text([1, 2, 5])),
    )
    whole["B_iso_or_equiv"] = atoms["B_iso_or_equiv"]
    assert atoms == whole
    assert atoms["B_iso_or_equiv"] == ["20.00"] * 2 * N + ["0.00"] * 2 * N + ["20.00"] * N


@pytest.mark.parametrize(
    "without",
    [
        ("auth_comp_id",),
        ("auth_atom_id",),
        ("auth_comp_id", "auth_atom_id", "auth_asym_id"),
        ("pdbx_PDB_model_num",),
        ("pdbx_PDB_ins_code", "pdbx_formal_charge", "B_iso_or_equiv", "occupancy"),
        ("label_entity_id", "label_seq_id", "group_PDB"),
    ],
)
def test_columns_may_be_absent(without):
    chain = "A" if "auth_asym_id" in without else "X"
    gap = Changes(
        added=tuple(
            AddedResidue(
                0,
                chain,
                k + 100,
                "",
                "U",
                (chain, k + 99, ""),
                NAMES,
                tuple(n[0] for n in NAMES),
                [place_of(k, name) for name in NAMES],
                1.0,
                20.0,
            )
            for k in (3, 4)
        )
    )
    atoms = _atoms(cif_text([1, 2, 5], without=without), gap)
    whole = cif.read_string(cif_text([1, 2, 3, 4, 5], without=without)).sole_block()
    assert atoms == whole.get_mmcif_category("_atom_site.")


def test_a_file_without_any_name_of_the_author_goes_by_its_own():
    without = ("auth_seq_id", "auth_comp_id", "auth_asym_id", "auth_atom_id")
    atoms = _atoms(
        cif_text([1, 2, 5], without=without),
        Changes(added=(added(3, ("A", 2, "")), added(4, ("A", 3, "")))),
    )
    assert atoms["label_seq_id"] == [str(k) for k in range(1, 6) for _ in range(N)]


def test_columns_that_nothing_here_knows_have_no_value_in_new_rows():
    text = cif_text([1, 2, 5]).replace(
        "_atom_site.Cartn_x\n", "_atom_site.odd\n_atom_site.Cartn_x\n"
    )
    rows = text.split("\n")
    odd = [r.replace(" ? ", " ? odd ", 1) if r.startswith(("ATOM", "HETATM")) else r for r in rows]
    atoms = _atoms("\n".join(odd))
    assert atoms["odd"] == ["odd"] * 2 * N + [None] * 2 * N + ["odd"] * N


def test_a_place_in_the_record_is_as_given_or_as_the_scheme_has_it_or_unknown():
    scheme = (
        "loop_",
        "_pdbx_poly_seq_scheme.asym_id",
        "_pdbx_poly_seq_scheme.seq_id",
        "_pdbx_poly_seq_scheme.pdb_strand_id",
        "_pdbx_poly_seq_scheme.pdb_seq_num",
        "_pdbx_poly_seq_scheme.pdb_ins_code",
        "A 33 X 103 .",
        "A 34 X 104 .",
    )
    for more, record, expected in (((), 77, "77"), (scheme, None, "33"), ((), None, "3")):
        atoms = _atoms(cif_text([1, 2, 5], *more), Changes(added=(_new(3, 2, record=record),)))
        assert atoms["label_seq_id"][2 * N : 3 * N] == [expected] * N
    # 102B after 102: no number between 2 and 5 is known to be its own
    text = cif_text([1, 2, 5])
    new = _new(3, 2, icode="B")
    assert _atoms(text, Changes(added=(new,)))["label_seq_id"][2 * N] is None
    assert _atoms(text, Changes(added=(new,)))["pdbx_PDB_ins_code"][2 * N] == "B"


def test_each_model_is_filled_by_itself():
    text = cif_text([1, 2, 5], models=2)
    gap = Changes(added=tuple(_new(k, k - 1, model=m) for k in (4, 3) for m in (1, 0)))
    atoms = _atoms(text, gap)
    whole = cif.read_string(cif_text([1, 2, 3, 4, 5], models=2)).sole_block()
    for name, values in whole.get_mmcif_category("_atom_site.").items():
        assert name == "B_iso_or_equiv" or atoms[name] == values
    (one,) = {len(set(_atoms(text, Changes(added=gap.added[:1] + gap.added[2:3]))["id"]))}
    assert one == 6 * N + 2 * N


def test_ids_that_do_not_rise_stay_and_new_ones_are_their_own():
    rows = cif_text([1, 2, 5]).split("\n")
    ids = iter(range(3 * N, 0, -1))
    text = "\n".join(
        " ".join([(w := r.split(" "))[0], str(next(ids)), *w[2:]]) if r.startswith("ATOM") else r
        for r in rows
    )
    atoms = _atoms(text)
    old = [str(k) for k in range(3 * N, 0, -1)]
    assert atoms["id"][: 2 * N] + atoms["id"][4 * N :] == old
    assert len(set(atoms["id"])) == 5 * N


ANISO = ("loop_", "_atom_site_anisotrop.id", "_atom_site_anisotrop.U[1][1]")


def test_whatever_names_an_atom_by_its_id_follows():
    last = 2 * N + 1
    more = (
        *ANISO,
        "1 0.1",
        f"{last} 0.2",
        "_geom_bond.atom_site_id_1 1",
        f"_geom_bond.atom_site_id_2 {last}",
    )
    block = _block(cif_text([1, 2, 5], *more))
    aniso = block.get_mmcif_category("_atom_site_anisotrop.")
    assert aniso == {"id": ["1", str(last + 2 * N)], "U[1][1]": ["0.1", "0.2"]}
    bond = block.get_mmcif_category("_geom_bond.")
    assert bond == {"atom_site_id_1": ["1"], "atom_site_id_2": [str(last + 2 * N)]}


def test_missing_atoms_come_into_their_nucleotide():
    text = cif_text([1, 2, 5])
    rows = text.split("\n")
    partial = [r for r in rows if not (" 102 " in r and ('"C4\'"' in r or '"P"' in r))]
    new = _new(2, 1, names=("C4'", "P"))
    atoms = _atoms("\n".join(partial), Changes(added=(new,)))
    assert atoms["auth_atom_id"] == list(NAMES) * 3
    assert atoms["label_seq_id"][N : 2 * N] == ["2"] * N


def test_locations_are_respected():
    rows = cif_text([1, 2]).split("\n")
    both = []
    for row in rows:
        if " 102 " in row and '"C1\'"' in row:
            continue
        both += [row.replace('" . U', f'" {a} U') for a in "AB"] if " 102 " in row else [row]
    text = "\n".join(both)
    atoms = _atoms(text, Changes(added=(_new(2, 1, names=("C1'",)),)))
    names = list(zip(atoms["label_atom_id"], atoms["label_alt_id"], strict=True))[N:]
    assert names[-3:] == [("C1'", False), ("N1", "A"), ("N1", "B")]
    assert len(names) == 2 * (N - 1) + 1


def test_modified_nucleotides_are_hetatm_rows():
    atoms = _atoms(cif_text([1, 2, 5]), Changes(added=(_new(3, 2, resname="5MU"), _new(4, 3))))
    assert atoms["group_PDB"] == ["ATOM"] * 2 * N + ["HETATM"] * N + ["ATOM"] * 2 * N


def test_a_moved_atom_has_one_location_and_no_ellipsoid():
    text = cif_text([1, 2], *ANISO, "1 0.1", "2 0.2")
    changes = Changes(
        moved={(0, "X", 101, "", "P"): np.array([1.0, 2.0, -3.0])},
        moved_occupancy=0.5,
        moved_b_factor_A2=80.0,
    )
    block = _block(text, changes)
    atoms, old = (
        b.get_mmcif_category("_atom_site.") for b in (block, cif.read_string(text).sole_block())
    )
    new = {name: values[0] for name, values in atoms.items() if values[0] != old[name][0]}
    assert new == {
        "Cartn_x": "1.000",
        "Cartn_y": "2.000",
        "Cartn_z": "-3.000",
        "occupancy": "0.50",
        "B_iso_or_equiv": "80.00",
    }
    assert {name: values[1:] for name, values in atoms.items()} == {
        name: values[1:] for name, values in old.items()
    }
    assert block.get_mmcif_category("_atom_site_anisotrop.")["id"] == ["2"]


def test_a_water_goes_with_what_names_it():
    more = (
        *ANISO,
        f"{2 * N + 1} 0.1",
        f"{2 * N + 2} 0.2",
        "loop_",
        "_pdbx_nonpoly_scheme.asym_id",
        "_pdbx_nonpoly_scheme.pdb_strand_id",
        "_pdbx_nonpoly_scheme.pdb_seq_num",
        "_pdbx_nonpoly_scheme.pdb_mon_id",
        "B X 140 HOH",
        "B X 141 HOH",
        "_struct_conn.id metalc1",
        "_struct_conn.ptnr1_auth_asym_id X",
        "_struct_conn.ptnr1_auth_seq_id 101",
        "_struct_conn.ptnr2_auth_asym_id X",
        "_struct_conn.ptnr2_auth_seq_id 140",
        "loop_",
        "_struct_site_gen.id",
        "_struct_site_gen.auth_asym_id",
        "_struct_site_gen.auth_seq_id",
        "1 X 140",
        "2 X 141",
        "loop_",
        "_entity.id",
        "_entity.type",
        "_entity.pdbx_number_of_molecules",
        "1 polymer 1",
        "2 water 2",
    )
    text = cif_text([1, 2], *more, waters=(40, 41))
    block = _block(text, Changes(removed=(Removed(0, "X", 140, "", "HOH"),)))
    assert block.get_mmcif_category("_atom_site.")["auth_seq_id"][-2:] == ["102", "141"]
    assert block.get_mmcif_category("_atom_site_anisotrop.")["U[1][1]"] == ["0.2"]
    assert block.get_mmcif_category("_pdbx_nonpoly_scheme.")["pdb_seq_num"] == ["141"]
    assert block.get_mmcif_category("_struct_conn.") == {}
    assert block.get_mmcif_category("_struct_site_gen.")["auth_seq_id"] == ["141"]
    assert block.get_mmcif_category("_entity.")["pdbx_number_of_molecules"] == ["1", "1"]


def test_what_names_a_water_stays_while_a_model_has_it():
    scheme = ("_pdbx_nonpoly_scheme.pdb_strand_id X", "_pdbx_nonpoly_scheme.pdb_seq_num 140")
    text = cif_text([1], *scheme, waters=(40,), models=2)
    block = _block(text, Changes(removed=(Removed(1, "X", 140, "", "HOH"),)))
    assert block.find_value("_pdbx_nonpoly_scheme.pdb_seq_num") == "140"


def test_a_file_without_atoms_is_refused():
    with pytest.raises(StructureError, match="no table _atom_site"):
        compose_cif("data_x\n_entry.id x\n", GAP)


def test_of_two_locations_of_a_moved_atom_one_is_left_without_a_name():
    rows = cif_text([1]).split("\n")
    both = [
        x
        for row in rows
        for x in ([row.replace('"P" .', f'"P" {a}') for a in "AB"] if '"P" .' in row else [row])
    ]
    changes = Changes(moved={(0, "X", 101, "", "P"): (1.0, 2.0, 3.0)})
    atoms = _atoms("\n".join(both), changes)
    assert atoms["label_atom_id"] == list(NAMES)
    assert set(atoms["label_alt_id"]) == {False}


def test_no_place_in_the_record_is_given_twice():
    rows = cif_text([1, 2, 5]).split("\n")
    # numbered without regard to what is missing
    text = "\n".join(row.replace(" A 1 5 ?", " A 1 3 ?") for row in rows)
    atoms = _atoms(text, Changes(added=(_new(3, 2),)))
    assert atoms["label_seq_id"][2 * N :] == [None] * N + ["3"] * N
