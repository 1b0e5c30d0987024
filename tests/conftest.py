import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure

# structures with gaps that several rooms fill
sys.path.insert(0, str(Path(__file__).parent))

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Neighbours in one process, which makes what they share once; who is idle takes from others.

    By default, a process gets tests from all modules.
    """
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log) if config.option.dist == "load" else None


@pytest.fixture(scope="session")
def hairpin_folder():
    folder = SHARED / "hairpins"
    if not folder.is_dir():
        pytest.skip("the reference structures are not beside this checkout (../shared/hairpins)")
    return folder


@pytest.fixture(scope="session")
def rod_folder():
    folder = SHARED / "rods"
    if not folder.is_dir():
        pytest.skip("the reference equilibria are not beside this checkout (../shared/rods)")
    return folder


@pytest.fixture
def rng():
    return np.random.default_rng(20181115)


# 2KOC: RNA, UUCG, 20 NMR models; most tests look at it


@pytest.fixture(scope="session")
def koc():
    return read_structure(data_path("hairpins/2koc.pdb"))


@pytest.fixture(scope="session")
def koc_lines():
    """Atom records of its first model."""
    text = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0]
    return [line for line in text.splitlines() if line.startswith(("ATOM", "HETATM"))]


@pytest.fixture(scope="session")
def fold(koc):
    (loop,) = le.fold(
        koc, all_models=False, stem_extend_5=0, stem_extend_3=0, taper=0, shapes="rod"
    )
    return loop


@pytest.fixture(scope="session")
def koc_shape(koc):
    """The loop of 2KOC's eighth model."""
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.shapes import loop_shape

    (hairpin,) = find_hairpins(koc)
    shape, _ = loop_shape(koc.nucleotides, hairpin, koc.positions(7), "2koc A.5-A.10")
    return shape


@pytest.fixture(scope="session")
def of_chains(koc_shape):
    """In place of the hypotheses of a loop: that shape, one of it that is smaller, and rods."""
    from loopelastica.folding.hypotheses import Hypothesis, straight_rods
    from loopelastica.folding.lines import chain_lines

    small = dataclasses.replace(koc_shape, steps_A=0.9 * koc_shape.steps_A, source="small")

    def hypotheses(hairpin, stem, ends, rods, *_):
        lines = chain_lines([koc_shape, small], stem.closing(), hairpin.is_dna)
        errors = np.array([0.5, 1.2, 2.0]), np.array([1.0, 2.0, 4.0])
        chains = [
            Hypothesis(line, f"like {line.shape.source}", expected, place)
            for place, (line, expected) in enumerate(zip(lines, errors, strict=True))
        ]
        straight = straight_rods(hairpin, rods, ends)
        return *chains, *(dataclasses.replace(rod, place=2 + rod.place) for rod in straight)

    return hypotheses


@pytest.fixture(scope="session")
def chains(koc, of_chains):
    """2KOC folded as these chains and as rods."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("loopelastica.folding.fold.hypotheses", of_chains)
        (loop,) = le.fold(koc, all_models=False)
    return loop


@pytest.fixture(scope="session")
def models(koc, fold):
    pytest.importorskip("rdkit")
    return le.build_atoms(koc, fold, max_candidates=2)


@pytest.fixture(scope="session")
def atoms(koc, fold, models):
    from loopelastica.report.atoms import LoopAtoms

    return LoopAtoms(koc, fold, tuple(models), koc.positions(0))


_CIF_COLUMNS = (
    *("group_PDB", "id", "type_symbol", "label_atom_id", "label_alt_id", "label_comp_id"),
    *("label_asym_id", "label_entity_id", "label_seq_id", "pdbx_PDB_ins_code"),
    *("Cartn_x", "Cartn_y", "Cartn_z", "occupancy", "B_iso_or_equiv"),
    *("auth_seq_id", "auth_comp_id", "auth_asym_id", "auth_atom_id", "pdbx_PDB_model_num"),
)


@pytest.fixture(scope="session")
def write_cif(koc_lines):
    """Write 2KOC as mmCIF, its one chain under any name that the format can hold."""

    def write(path, chain):
        name = f"\n;{chain}\n;\n" if "\n" in chain else f"'{chain}'"
        lines = ["data_x", "loop_", *(f"_atom_site.{column}" for column in _CIF_COLUMNS)]
        for line in koc_lines:
            atom, residue, number = (line[12:16].strip(), line[17:20].strip(), line[22:26].strip())
            place = f"{line[30:38]} {line[38:46]} {line[46:54]} 1.0 0.0"
            atom = f'"{atom}"'
            lines.append(
                f"ATOM {line[6:11]} {line[76:78]} {atom} . {residue} A 1 {number} ? {place}"
                f" {number} {residue} {name} {atom} 1"
            )
        path.write_text("\n".join([*lines, ""]), encoding="utf-8")
        return path

    return write
