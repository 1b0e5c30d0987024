"""Nucleotides are known by their atoms, whatever the file calls them."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from loopelastica.molecule.nucleotides import (
    BACKBONE,
    atom_positions,
    centroids,
    linked,
    read_structure,
)


def renamed(lines: list[str], resname: str, number: int | None = None) -> list[str]:
    """Atom records with another residue name, in all residues or in one."""
    return [
        line[:17] + f"{resname:>3s}" + line[20:]
        if number is None or int(line[22:26]) == number
        else line
        for line in lines
    ]


def without(lines: list[str], number: int, *names: str) -> list[str]:
    """Records without the named atoms of one residue."""
    return [
        line
        for line in lines
        if int(line[22:26]) != number or (names and line[12:16].strip() not in names)
    ]


def test_residue_names_do_not_matter(pdb, koc_lines, koc):
    strange = read_structure(pdb(renamed(koc_lines, "XYZ"))).nucleotides
    assert "".join(strange.letter) == "GGCACUUCGGUGCC"
    assert not strange.is_dna.any()
    assert strange.label(11) == "A.XYZ12"
    np.testing.assert_array_equal(strange.atom_index, koc.nucleotides.atom_index)


def test_old_atom_names_are_understood(pdb, koc_lines, koc):
    def old(line: str) -> str:
        name = line[12:16].replace("'", "*").replace("OP1", "O1P").replace("OP2", "O2P")
        return line[:12] + name + line[16:]

    table = read_structure(pdb([old(line) for line in koc_lines])).nucleotides
    np.testing.assert_array_equal(table.atom_index, koc.nucleotides.atom_index)


def test_a_sugar_without_o2_is_dna_and_then_the_methyl_makes_t(pdb, koc_lines):
    lines = [line for line in koc_lines if line[12:16].strip() != "O2'"]
    h5 = next(k for k, line in enumerate(lines) if line[12:26] == " H5    U A   6")
    for methyl in (" C7 ", " C5M"):
        lines[h5] = lines[h5][:12] + methyl + lines[h5][16:]
        table = read_structure(pdb(lines)).nucleotides
        assert table.is_dna.all()
        assert "".join(table.letter) == "GGCACTUCGGUGCC"


def test_a_methyl_on_rna_leaves_the_parent_u(pdb, koc_lines):
    lines = [
        line[:12] + " C5M" + line[16:] if line[12:26] == " H5    U A   6" else line
        for line in koc_lines
    ]
    assert read_structure(pdb(lines)).nucleotides.letter[5] == "U"


def test_modified_bases_keep_their_parent(hairpins_folder):
    table = read_structure(hairpins_folder / "1ehz.cif.gz").nucleotides
    parent = dict(zip(table.resname.tolist(), table.letter.tolist(), strict=True))
    expected = {
        **{"2MG": "G", "M2G": "G", "OMG": "G", "7MG": "G", "YYG": "G", "1MA": "A"},
        **{"H2U": "U", "PSU": "U", "5MU": "U", "OMC": "C", "5MC": "C"},
    }
    assert {name: parent[name] for name in expected} == expected
    assert len(table) == 76
    assert not table.is_dna.any()


def test_uracil_in_dna_stays_u_and_insertion_codes_stay_apart(hairpins_folder):
    table = read_structure(hairpins_folder / "1idx.pdb.gz").nucleotides
    assert "".join(table.letter) == "AGGATCCTTUTGGATCCT"
    assert table.is_dna.all()
    labels = [table.label(i) for i in range(len(table))]
    assert "A.DG3^B" in labels
    assert len(set(labels)) == 18


def test_a_free_base_is_no_nucleotide(hairpins_folder):
    table = read_structure(hairpins_folder / "1y26.pdb.gz").nucleotides
    assert len(table) == 71
    assert "ADE" not in table.resname


def test_protein_and_missing_chains(hairpins_folder):
    table = read_structure(hairpins_folder / "boxb_nochain.pdb.gz").nucleotides
    assert len(table) == 19
    assert table.label(6) == "U7"


def test_other_names_of_other_programs(hairpins_folder):
    charmm = read_structure(hairpins_folder / "1k5i_c36.pdb.gz").nucleotides
    assert "".join(charmm.letter) == "GGACCCGGGCUCAACCUGGGUCC"
    assert charmm.label(8) == "GUA9"
    rosetta = read_structure(hairpins_folder / "1zih_rosetta.pdb.gz").nucleotides
    assert "".join(rosetta.letter) == "GGGCGCAAGCCU"


@pytest.mark.parametrize(("a", "b", "x"), [(0.4, 0.6, 200.0), (0.6, 0.4, 100.0), (0.5, 0.5, 100.0)])
def test_the_fuller_altloc_counts_and_the_first_among_equals(pdb, koc_lines, a, b, x):
    lines = []
    for line in koc_lines:
        if line[12:26] == " P     U A   6":
            for letter, occupancy, place in (("A", a, 100.0), ("B", b, 200.0)):
                lines.append(
                    f"{line[:16]}{letter}{line[17:30]}{place:8.3f}{line[38:54]}"
                    f"{occupancy:6.2f}{line[60:]}"
                )
        else:
            lines.append(line)
    structure = read_structure(pdb(lines))
    p = atom_positions(structure.nucleotides, structure.positions(0), ("P",))
    assert p[5, 0, 0] == pytest.approx(x)


@pytest.mark.parametrize(
    ("first", "second", "label"),
    [(0.3, 0.7, "A.5BU6"), (0.7, 0.3, "A.U6"), (0.5, 0.5, "A.U6")],
)
def test_two_residues_at_one_place_are_one_nucleotide(pdb, koc_lines, first, second, label):
    sixth = [line for line in koc_lines if int(line[22:26]) == 6]
    lines = []
    for line in koc_lines:
        if int(line[22:26]) != 6:
            lines.append(line)
        elif line == sixth[0]:
            for altloc, resname, occupancy in (("A", "  U", first), ("B", "5BU", second)):
                lines += [
                    f"{atom[:16]}{altloc}{resname}{atom[20:54]}{occupancy:6.2f}{atom[60:]}"
                    for atom in sixth
                ]
    structure = read_structure(pdb(lines))
    table = structure.nucleotides
    assert len(table) == 14
    assert table.label(5) == label
    assert linked(table, structure.positions(0)).all()


def test_a_nucleotide_without_a_base_still_carries_the_chain(pdb, koc_lines):
    keep = (*BACKBONE, "OP1", "OP2", "C1'", "C2'", "O2'", "O4'")
    lines = [line for line in koc_lines if int(line[22:26]) != 7 or line[12:16].strip() in keep]
    structure = read_structure(pdb(lines))
    assert "".join(structure.nucleotides.letter) == "GGCACUNCGGUGCC"
    assert linked(structure.nucleotides, structure.positions(0)).all()


def test_the_chain_breaks_where_a_nucleotide_is_missing(pdb, koc_lines):
    structure = read_structure(pdb(without(koc_lines, 7)))
    joined = linked(structure.nucleotides, structure.positions(0))
    assert np.flatnonzero(~joined).tolist() == [5]


def test_the_chain_goes_on_by_number_where_p_is_missing(pdb, koc_lines):
    structure = read_structure(pdb(without(koc_lines, 7, "P")))
    assert linked(structure.nucleotides, structure.positions(0)).all()
    far = [line[:22] + "  27" + line[26:] if line[22:26] == "   7" else line for line in koc_lines]
    structure = read_structure(pdb(without(far, 27, "P")))
    assert not linked(structure.nucleotides, structure.positions(0)).all()


def test_two_chains_are_not_joined(pdb, koc_lines):
    lines = [line[:21] + "B" + line[22:] if int(line[22:26]) > 7 else line for line in koc_lines]
    structure = read_structure(pdb(lines))
    assert structure.nucleotides.label(7) == "B.C8"
    joined = linked(structure.nucleotides, structure.positions(0))
    assert np.flatnonzero(~joined).tolist() == [6]


def test_centroid_is_the_mean_of_six_atoms_or_nothing(pdb, koc_lines):
    structure = read_structure(pdb(without(koc_lines, 1, "P")))
    middle = centroids(structure.nucleotides, structure.positions(0))
    assert np.isnan(middle[0]).all()
    assert np.isfinite(middle[1:]).all()
    expected = np.mean(
        [
            [float(line[30 + 8 * k : 38 + 8 * k]) for k in range(3)]
            for line in koc_lines
            if int(line[22:26]) == 6 and line[12:16].strip() in BACKBONE
        ],
        axis=0,
    )
    np.testing.assert_allclose(middle[5], expected, atol=1e-5)


def test_an_unknown_atom_name_is_refused(koc):
    with pytest.raises(ValueError, match="'XX'"):
        atom_positions(koc.nucleotides, koc.positions(0), ("P", "XX"))


def test_importing_the_molecule_does_not_import_mdanalysis():
    code = (
        "import sys, loopelastica.molecule.ends, loopelastica.molecule.trace;"
        "print([m for m in ('MDAnalysis', 'scipy', 'gemmi') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_of_an_atom_written_twice_the_first_counts(pdb, koc_lines):
    lines = [
        copy
        for line in koc_lines
        for copy in (
            [line, line[:30] + f"{200.0:8.3f}" + line[38:]]
            if line[12:26] == " P     U A   6"
            else [line]
        )
    ]
    structure = read_structure(pdb(lines))
    p = atom_positions(structure.nucleotides, structure.positions(0), ("P",))
    assert p[5, 0, 0] < 100.0


def test_altlocs_of_many_residues_are_chosen_one_by_one(pdb, koc_lines):
    lines = []
    for line in koc_lines:
        first = f"{line[:16]}A{line[17:54]}  0.40{line[60:]}"
        second = f"{line[:16]}B{line[17:54]}  0.60{line[60:]}"
        third = f"{line[:16]}C{line[17:54]}  0.70{line[60:]}"
        lines += [second, first, third] if line[22:26] == "   7" else [second, first]
    taken = read_structure(pdb(lines)).nucleotides.altloc
    assert "".join(taken) == "BBBBBBCBBBBBBB"
