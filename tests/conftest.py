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
    (loop,) = le.fold(koc, all_models=False, stem_extend_5=0, stem_extend_3=0, taper=0)
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
