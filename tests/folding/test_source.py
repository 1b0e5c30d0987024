"""What a loop was folded in: read again, or kept as it was."""

import gc
import pickle
import shutil
import tracemalloc
import warnings

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.molecule.nucleotides import read_structure

HAIRPIN = data_path("hairpins/2koc.pdb")
RODS = {"all_models": False, "shapes": "rod"}


@pytest.fixture
def universe():
    import MDAnalysis as mda

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return mda.Universe(HAIRPIN)


@pytest.fixture
def copied(tmp_path):
    return shutil.copy(HAIRPIN, tmp_path / "a.pdb")


def test_a_file_is_read_again_wherever_one_has_gone(copied, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (loop,) = le.fold("a.pdb", **RODS)
    assert loop.source.file == "a.pdb"
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    again = loop.structure()
    np.testing.assert_array_equal(again.positions(0), read_structure(copied).positions(0))


def test_a_file_that_changed_or_went_is_named(copied, tmp_path):
    (loop,) = le.fold(copied, **RODS)
    with open(copied, "a") as file:
        file.write("REMARK\n")
    for use in (loop.plot, loop.structure, lambda: loop.write(tmp_path / "out"), loop.atoms):
        with pytest.raises(le.StructureError, match=r"a\.pdb: the file has changed"):
            use()
    assert not (tmp_path / "out").exists()
    (tmp_path / "a.pdb").unlink()
    with pytest.raises(le.StructureError, match=r"a\.pdb: the file cannot be read again"):
        loop.structure()


def test_a_frame_stays_as_it_was_folded(universe):
    universe.trajectory[3]
    (loop,) = le.fold(universe, **RODS)
    folded = np.array(universe.atoms.positions, dtype=float)
    universe.trajectory[0]
    universe.atoms.translate([5.0, 0.0, 0.0])
    np.testing.assert_array_equal(loop.structure().positions(0), folded)
    assert loop.source.about == {"universe": "2koc.pdb", "frame": 3}


def test_a_group_keeps_its_own_nucleotides_and_the_atoms_around(universe):
    (loop,) = le.fold(universe.select_atoms("resid 3:12"), **RODS)
    again = loop.structure()
    assert len(again.nucleotides) == 10
    assert len(again.universe.atoms) == len(universe.atoms)
    names = again.universe.atoms.names[again.nucleotides.columns(("P",))[:, 0]]
    assert set(names) == {"P"}
    hairpin = loop.hairpin
    labels = tuple(again.nucleotides.label(int(row)) for row in hairpin.loop)
    assert labels == hairpin.residues


def _with_water(universe, first):
    """The hairpin among as many waters, before or behind it."""
    import MDAnalysis as mda

    n = 300
    water = mda.Universe.empty(n, n_residues=n, atom_resindex=np.arange(n), trajectory=True)
    for name, value in {"names": "O", "resnames": "SOL", "chainIDs": "W"}.items():
        water.add_TopologyAttr(name, [value] * n)
    water.add_TopologyAttr("resids", np.arange(1, n + 1))
    water.atoms.positions = 40.0 + np.random.default_rng(1).random((n, 3)) * 20.0
    parts = [water.atoms, universe.atoms] if first else [universe.atoms, water.atoms]
    return mda.Merge(*parts)


@pytest.mark.parametrize("first", [True, False])
def test_water_is_left_out_and_that_is_said(universe, first):
    both = _with_water(universe, first)
    (loop,) = le.fold(both, **RODS)
    again = loop.structure()
    assert len(again.universe.atoms) == len(universe.atoms)
    assert "300 atoms of water are not kept, nor written" in again.remarks
    rows = again.nucleotides.columns(("C1'",))[:, 0]
    own = read_structure(universe).nucleotides.columns(("C1'",))[:, 0]
    np.testing.assert_array_equal(again.positions(0)[rows], universe.atoms.positions[own])


def test_loops_of_a_universe_are_sent_without_its_file(copied, tmp_path):
    import MDAnalysis as mda

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        universe = mda.Universe(copied)
    folds = le.fold(universe, **RODS)
    sent = pickle.dumps(folds)
    (tmp_path / "a.pdb").unlink()
    again = pickle.loads(sent)
    assert isinstance(again, le.Folds)
    folder = again[0].write(tmp_path / "out", plot=False)
    assert folder.name == "universe_A6-9"


def test_folds_of_files_hold_no_structure():
    # compiled code and tables are loaded before
    le.fold(HAIRPIN, **RODS)
    tracemalloc.start()
    held = [le.fold(HAIRPIN, **RODS) for _ in range(5)]
    gc.collect()
    mean = tracemalloc.get_traced_memory()[0] / len(held)
    tracemalloc.stop()
    # the structure alone has 400 kB
    assert mean < 100_000


def test_a_built_hairpin_has_no_loop_of_its_own(tmp_path):
    loop = le.build("GGC(GAA)GCC", rna=False).loop
    setting = loop.setting()
    assert setting.names == ("G4", "A5", "A6")
    assert len(setting.loop_bonds_A) == 0
    assert len(setting.stem_bonds_A) > 100


def test_a_loop_without_a_source_says_so(koc):
    from loopelastica.folding.fold import fold_hairpins
    from loopelastica.folding.options import FoldOptions
    from loopelastica.molecule.hairpins import find_hairpins

    (loop,) = fold_hairpins(koc, find_hairpins(koc), FoldOptions(**RODS))
    with pytest.raises(le.StructureError, match=r"A\.C5–A\.G10: what it was folded in is not"):
        loop.plot()
