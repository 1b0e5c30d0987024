"""Strands that are like one of another structure."""

import gapped
import numpy as np
import pytest

import loopelastica as le
from loopelastica.errors import StructureError
from loopelastica.molecule.templates import monomer_of

pytest.importorskip("rdkit")


@pytest.fixture
def open_loop(tmp_path):
    """2KOC without its loop."""
    return gapped.gapped(tmp_path / "open.pdb", {6, 7, 8, 9})


@pytest.fixture
def other(tmp_path):
    """The eighth model of 2KOC."""
    return gapped.pdb(tmp_path / "eighth.pdb", gapped.chain(model=8))


def off_A(koc, strand):
    """RMSD of all heavy atoms of 2KOC's loop that were built, where they are."""
    own = {
        monomer.label: monomer.atoms_A
        for monomer in (monomer_of(koc.nucleotides, row, koc.positions(0)) for row in range(5, 9))
    }
    return np.sqrt(
        np.mean(
            [
                ((at - own[residue.monomer.label][name]) ** 2).sum()
                for residue in strand.candidates[0].atoms.residues
                for name, at in zip(residue.names, residue.positions_A, strict=True)
                if residue.monomer.label in own
            ]
        )
    )


@pytest.mark.parametrize("pair", ["", ":A.5-A.10"])
def test_a_gap_gets_the_loop_of_another_structure(koc, open_loop, other, pair):
    (plain,) = le.fill(open_loop).strands
    (strand,) = le.fill(open_loop, like=f"{other}{pair}").strands
    assert strand.sound
    assert strand.shape == strand.candidates[0].shape == "like eighth A.5-A.10"
    assert strand.candidates[0].atoms.near
    assert off_A(koc, strand) < 1.5
    assert off_A(koc, strand) < 0.5 * off_A(koc, plain)
    low, middle, high = strand.expected_rmsd_A
    assert 0 < low < middle < high


def test_the_chain_is_sound_and_nothing_else_changes(open_loop, other, tmp_path):
    filling = le.fill(open_loop, like=other)
    out = filling.write(tmp_path / "filled.pdb")
    gapped.check_chain(gapped.read(out))
    assert "like eighth A.5-A.10" in out.read_text()


def test_other_letters_get_their_own_bases(open_loop, other):
    (strand,) = le.fill(open_loop, strands="A.6-9=GAAA", like=f"{other}:A.5-A.10").strands
    assert (strand.sequence, strand.shape) == ("GAAA", "like eighth A.5-A.10")
    assert strand.sound
    names = [residue.kind.standard for residue in strand.candidates[0].atoms.residues]
    assert names[:4] == ["G", "A", "A", "A"]


def test_dna_is_filled_like_rna(tmp_path, other):
    path = gapped.gapped(tmp_path / "dna.pdb", {6, 7, 8, 9}, dna=True)
    (strand,) = le.fill(path, like=f"{other}:A.5-A.10").strands
    assert (strand.kind, strand.shape) == ("DNA", "like eighth A.5-A.10")
    assert strand.sound
    assert not any("O2'" in residue.names for residue in strand.candidates[0].atoms.residues)


def test_a_strand_that_is_no_hairpin_loop(koc, other, tmp_path):
    path = gapped.gapped(tmp_path / "helix.pdb", {2, 3, 4})
    (strand,) = le.fill(path, like=f"{other}:A.1-A.5").strands
    assert strand.shape == "like eighth A.1-A.5"
    assert strand.sound


def test_rods_come_after_templates(open_loop, other):
    (strand,) = le.fill(open_loop, like=other, candidates=2).strands
    assert [c.shape for c in strand.candidates] == [
        "like eighth A.5-A.10", "rod in its surroundings",
    ]  # fmt: skip
    assert [c.rank for c in strand.candidates] == [1, 2]


def test_one_nucleotide_less_is_respaced_and_that_is_said(open_loop, other):
    (strand,) = le.fill(open_loop, like=f"{other}:A.5-A.9").strands
    assert strand.shape == "like eighth A.5-A.9, 3 → 4 nucleotides"
    assert not strand.candidates[0].atoms.near
    assert any("the line of 3 is respaced" in sentence for sentence in strand.remarks)


def test_a_template_that_fits_nothing_is_refused(open_loop, other):
    with pytest.raises(
        StructureError, match=r"eighth\.pdb:A\.1-A\.3: its strand has 1 nucleotide, .* 4"
    ):
        le.fill(open_loop, like=f"{other}:A.1-A.3")
    with pytest.raises(StructureError, match=r"nowhere\.pdb: there is no such file"):
        le.fill(open_loop, like="nowhere.pdb")
    with pytest.raises(StructureError, match=r"no nucleotide A\.99"):
        le.fill(open_loop, like=f"{other}:A.1-A.99")


def test_of_two_gaps_one_is_filled_as_usual(tmp_path, other):
    path = gapped.gapped(tmp_path / "two.pdb", {2, 6, 7, 8, 9})
    first, second = le.fill(path, like=f"{other}:A.5-A.10").strands
    assert first.shape == "rod in its surroundings"
    assert any("no strand for its 1 nucleotide;" in sentence for sentence in first.remarks)
    assert second.shape == "like eighth A.5-A.10"


def test_what_the_record_says(open_loop, other, tmp_path):
    from loopelastica.filling.folder import record_of

    record = record_of(le.fill(open_loop, like=f"{other}:A.5-A.10"))
    assert record["parameters"]["like"] == f"{other}:A.5-A.10"
    (candidate,) = record["strands"][0]["candidates"]
    assert candidate["shape"] == "like eighth A.5-A.10"
    assert candidate["contact_energy_per_A"] is None
    assert candidate["stable"] is True
    assert candidate["residual"] < 1e-6
