"""Whole hairpins from their sequences."""

import pickle
from dataclasses import replace

import gemmi
import numpy as np
import pytest
from whole_hairpin import between, measured

import loopelastica as le
from loopelastica.errors import StructureError


@pytest.fixture(scope="module")
def rna():
    return le.build("GGUAC(UUCG)GUGCC", candidates=2)


@pytest.fixture(scope="module")
def dna():
    return le.build("gc tac (ttt) gtg gc", phosphate=True)


def is_sound(model):
    bond, angle, hands, closest = measured(model)
    return model.checks.sound and bond < 0.05 and angle < 10.0 and hands == 0 and closest > 2.2


def test_a_built_hairpin_is_whole(rna):
    atoms = rna.atoms
    assert rna.sequence == "GGUAC(UUCG)GUGCC"
    letters = {int(resid): name for resid, name in zip(atoms.resids, atoms.resnames, strict=True)}
    assert "".join(letters[k] for k in range(1, 15)) == "GGUACUUCGGUGCC"
    assert (atoms.chain, len(atoms.names)) == ("A", len(atoms.positions_A))
    assert len(set(zip(atoms.names, atoms.resids.tolist(), strict=True))) == len(atoms.names)
    assert set(atoms.elements) == {"P", "O", "N", "C"}
    assert np.all(np.diff(atoms.resids) >= 0)
    # the loop's rows are what every AtomModel has
    rows = rna.molecule.loop_atoms
    assert np.array_equal(atoms.positions_A[np.isin(atoms.resids, [6, 7, 8, 9])],
                          rna.positions_A[rows])  # fmt: skip
    assert isinstance(rna, le.AtomModel)


def test_a_built_hairpin_is_sound(rna, dna):
    assert is_sound(rna)
    assert is_sound(dna)


def test_a_built_hairpin_has_its_wobbles(rna, dna):
    for model, g, u in ((rna, 12, 3), (dna, 11, 3)):
        assert 2.7 < between(model, g, "O6", u, "N3") < 3.0
        assert 2.7 < between(model, g, "N1", u, "O2") < 3.0


def test_candidates_are_ranked_and_whole(rna):
    assert [model.rank for model in rna.candidates] == [1, 2]
    first, second = rna.candidates
    assert repr(first) == repr(rna)
    stem = ~np.isin(first.atoms.resids, [6, 7, 8, 9])
    assert np.array_equal(first.atoms.positions_A[stem], second.atoms.positions_A[stem])
    assert not np.array_equal(first.atoms.positions_A[~stem], second.atoms.positions_A[~stem])
    assert is_sound(second)


def test_a_universe_has_the_same_atoms(rna):
    universe = rna.universe()
    assert universe.atoms.names.tolist() == list(rna.atoms.names)
    assert universe.residues.resnames.tolist()[:3] == ["G", "G", "U"]
    assert universe.atoms.positions == pytest.approx(rna.atoms.positions_A, abs=1e-4)
    (found,) = le.find_hairpins(universe)
    assert found.closing_pair == ("A.C5", "A.G10")


def test_the_same_sequence_gives_the_same_atoms(rna):
    again = le.build("ggu ac uucg gugcc ((((( .... )))))")
    assert again.atoms.positions_A.tobytes() == rna.atoms.positions_A.tobytes()


def test_the_phosphate_is_an_option(rna, dna):
    def first(model):
        return {n for n, k in zip(model.atoms.names, model.atoms.resids, strict=True) if k == 1}

    assert {"P", "OP1", "OP2", "OP3"} <= first(dna)
    assert not {"P", "OP1", "OP2", "OP3"} & first(rna)


def test_modified_nucleotides_are_built():
    model = le.build("GG[5MC](UU[OMU]G)GUC")
    assert model.checks.sound
    methyl = {(n, r) for n, r in zip(model.atoms.names, model.atoms.resnames, strict=True)}
    assert {("CM5", "5MC"), ("CM2", "OMU")} <= methyl
    assert is_sound(model)


def test_a_stem_of_one_pair_is_built():
    assert is_sound(le.build("G(UUUU)C"))


def test_mismatches_are_built_where_they_are_let_be():
    model = le.build("GCAGC(UUCG)GCAGC", mismatches=True)
    assert is_sound(model)
    assert model.hairpin.structure.remarks == (
        "A3·A12 do not pair; they stand where they find room",
    )


@pytest.mark.parametrize(
    ("arguments", "options", "said"),
    [
        (("GGC(UUU)GC",), {}, "needs equal ones"),
        (("GGC(AAA)GCC",), {}, "`rna` is needed"),
        (("GGC(AAA)GCC", "RNA"), {}, "`rna` is 'RNA'; it must be True or False"),
        (("GGC(UUU)GCC",), {"candidates": 0}, "`candidates` is 0"),
        (("GGC(UUU)GCC",), {"contact": "wobble"}, "`contact` is 'wobble'"),
        (("GGC(UUU)GCC",), {"phosphate": 1}, "`phosphate` is 1"),
        (("GGCUUUGCC",), {"structure": "((.(.)))."}, "`structure`"),
    ],
)
def test_what_cannot_be_built_is_refused(arguments, options, said):
    with pytest.raises(ValueError, match=said):
        le.build(*arguments, **options)


def names_of(model, number):
    atoms = model.atoms
    return {n for n, k in zip(atoms.names, atoms.resids, strict=True) if k == number}


def test_hydrogens_are_an_option():
    model = le.build("GGC(GAA)GCC", rna=False, hydrogens=True)
    atoms = model.atoms
    assert {"HO5'", "H5'", "H5''", "H2'", "H2''", "H1", "H21", "H22"} <= names_of(model, 1)
    assert "HO3'" in names_of(model, 9)
    assert not {"HO3'", "HO5'", "HO2'"} & names_of(model, 5)
    heavy = np.array([element != "H" for element in atoms.elements])
    plain = le.build("GGC(GAA)GCC", rna=False)
    assert np.array_equal(atoms.positions_A[heavy], plain.atoms.positions_A)
    assert "H" not in plain.atoms.elements
    assert len(model.universe().atoms) == len(atoms.names)


@pytest.mark.parametrize("suffix", [".pdb", ".cif", ".mmcif"])
def test_a_model_is_written_by_its_suffix(rna, tmp_path, suffix):
    path = tmp_path / f"hairpin{suffix}"
    rna.write(path)
    (chain,) = gemmi.read_structure(str(path), format=gemmi.CoorFormat.Detect)[0]
    found = {(r.seqid.num, a.name): a.pos.tolist() for r in chain for a in r}
    atoms = rna.atoms
    assert set(found) == set(zip(atoms.resids.tolist(), atoms.names, strict=True))
    for number, name, at in zip(atoms.resids.tolist(), atoms.names, atoms.positions_A, strict=True):
        assert found[number, name] == pytest.approx(at, abs=1e-3)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_a_model_is_written_with_names_of_a_force_field(tmp_path):
    model = le.build("GGC(GAA)GCC", rna=False, hydrogens=True)
    model.write(tmp_path / "amber.pdb", names="amber")
    (chain,) = gemmi.read_structure(str(tmp_path / "amber.pdb"))[0]
    assert [residue.name for residue in chain][:2] == ["DG5", "DG"]
    assert chain[-1].name == "DC3"


def test_a_model_is_written_whole_or_not_at_all(rna, tmp_path):
    for name in ("hairpin.xyz", "hairpin", "pdb"):
        with pytest.raises(ValueError, match=r"it must end in \.pdb, \.cif or \.mmcif"):
            rna.write(tmp_path / name)
    with pytest.raises(ValueError, match="`path` is 7; it must be the name of a file"):
        rna.write(7)
    with pytest.raises(ValueError, match="`names` is 'gromos'"):
        rna.write(tmp_path / "hairpin.pdb", names="gromos")
    broken = replace(rna, checks=replace(rna.checks, worst_angle_deg=12.0))
    with pytest.raises(StructureError, match="off by 12°; a model that is not sound is not writ"):
        broken.write(tmp_path / "hairpin.pdb")
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match=r"hairpin\.pdb"):
        rna.write(tmp_path / "file" / "hairpin.pdb")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_model_survives_pickling(rna):
    again = pickle.loads(pickle.dumps(rna.atoms))
    assert again.positions_A.tobytes() == rna.atoms.positions_A.tobytes()


def hairpins(n):
    """Random stems with wobbles among their pairs, and loops of 3 to 10."""
    rng = np.random.default_rng(16)
    for k in range(n):
        pairs = ["GC", "CG", "AU", "UA", "GU", "UG"]
        rungs = [pairs[i] for i in rng.integers(0, 6, rng.integers(3, 8))]
        loop = "".join(rng.choice(list("ACGU"), 3 + k % 8))
        strand_3 = "".join(rung[1] for rung in reversed(rungs))
        text = f"{''.join(rung[0] for rung in rungs)}({loop}){strand_3}"
        yield (text.replace("U", "T"), False) if k // 8 % 2 else (text, True)


@pytest.mark.slow
@pytest.mark.parametrize(("text", "rna"), list(hairpins(20)))
def test_hairpins_of_all_lengths_are_sound(text, rna):
    model = le.build(text, rna)
    assert model.checks.wrong == ()
    bond, angle, hands, closest = measured(model)
    assert bond < 0.05
    assert angle < 10.0
    assert hands == 0
    assert closest > 2.2


def test_a_modified_nucleotide_of_the_stem_is_a_hetatm(tmp_path):
    model = le.build("GG[5MC]AC(UUCG)GUGCC")
    model.write(tmp_path / "modified.pdb")
    lines = (tmp_path / "modified.pdb").read_text(encoding="ascii").splitlines()
    records = {line[17:20].strip(): line[:6].strip() for line in lines if line[12:16] == " C1'"}
    assert records == {"G": "ATOM", "5MC": "HETATM", "A": "ATOM", "C": "ATOM", "U": "ATOM"}
