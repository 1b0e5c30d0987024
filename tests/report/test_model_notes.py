"""Titles and remarks of models."""

import dataclasses
import hashlib
from pathlib import Path

from loopelastica._files import data_path
from loopelastica._version import __version__
from loopelastica.report.model_notes import notes, title

SOURCE = data_path("hairpins/2koc.pdb")


def test_the_title_says_what_it_is(atoms):
    assert title(atoms, SOURCE) == (
        f"RNA LOOP A.U6 TO A.G9 (UUCG) OF 2koc.pdb, BY loopelastica {__version__}"
    )
    assert "OF SEQUENCE GGCAC(UUCG)GUGCC" in title(atoms, "GGCAC(UUCG)GUGCC")


def test_the_remarks_say_program_input_and_what_is_modelled(atoms):
    said = notes(atoms, atoms.written, SOURCE)
    assert said[0].startswith(f"loopelastica {__version__} ")
    assert f"  {hashlib.sha256(SOURCE.read_bytes()).hexdigest()}" in said
    assert "MODELLED: A.U6 TO A.G9, SEQUENCE UUCG, IN THE PAIR A.C5-A.G10" in said
    assert all(len(line) <= 69 and line.isascii() and line.isprintable() for line in said)


def test_the_remarks_say_of_each_model_rank_shape_energy_soundness_and_error(atoms):
    text = " ".join(" ".join(notes(atoms, atoms.written, SOURCE)).split())
    for number, model in enumerate(atoms.written, start=1):
        (candidate,) = (c for c in atoms.fold.candidates if c.rank == model.rank)
        checks = model.checks
        low, middle, high = candidate.expected_rmsd_A
        for part in (
            f"MODEL {number}: CANDIDATE {model.rank}: {candidate.shape}",
            f"ENERGY {candidate.energy_per_A:.4f} 1/A (E/K0), {candidate.energy_kT:.3f} KT",
            f"SOUND: converged, WORST BOND OFF BY {checks.worst_bond_A:.3f} A, WORST ANGLE BY"
            f" {checks.worst_angle_deg:.1f} DEG, CLOSEST CONTACT {checks.closest_A:.2f} A",
            f"EXPECTED ERROR {middle:.1f} A (80 % BETWEEN {low:.1f} AND {high:.1f})",
        ):
            assert part in text


def test_a_file_that_is_gone_has_no_digest(atoms):
    said = notes(atoms, atoms.written, Path("gone.pdb"))
    assert "INPUT: gone.pdb" in said


def test_no_name_breaks_a_line(atoms):
    odd = dataclasses.replace(atoms.fold.hairpin, residues=("A\n.U6", "\u202eB.G9"))
    fold = dataclasses.replace(atoms.fold, hairpin=odd)
    said = notes(dataclasses.replace(atoms, fold=fold), atoms.written, SOURCE)
    assert all(line.isascii() and line.isprintable() for line in said)
