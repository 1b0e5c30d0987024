"""Whole hairpins from their sequences."""

import numpy as np
import pytest
from whole_hairpin import between, measured

import loopelastica as le
from loopelastica.atoms.hairpin import ideal_hairpin
from loopelastica.atoms.sequence import read_sequence
from loopelastica.molecule.nucleotides import atom_positions
from loopelastica.molecule.pairs import canonical_pairs


@pytest.fixture(scope="module")
def rna():
    return le.build("GGUAC(UUCG)GUGCC", candidates=2)


@pytest.fixture(scope="module")
def dna():
    return le.build("gc tac (ttt) gtg gc", phosphate=True)


def is_sound(model):
    bond, angle, hands, closest = measured(model)
    return model.checks.sound and bond < 0.05 and angle < 10.0 and hands == 0 and closest > 2.2


@pytest.mark.parametrize("text", ["GACG(TTTT)CGTC", "GACG(UUUU)CGUC", "GGUG(UUUU)CGCC"])
def test_the_ideal_stem_is_paired_and_joined(text):
    structure, hairpin, positions = ideal_hairpin(read_sequence(text))
    table = structure.nucleotides
    kind = "D" if "T" in text else ""
    assert hairpin.closing_pair == (f"A.{kind}G4", f"A.{kind}C9")
    assert "".join(table.letter) == text.replace("(", "").replace(")", "")
    stem = structure.positions(0)
    pairs = [pair for pair in canonical_pairs(table, stem).tolist() if pair[0] < 4]
    assert pairs == [[0, 11], [1, 10], [2, 9], [3, 8]]
    o3, p = np.moveaxis(atom_positions(table, stem, ("O3'", "P")), 1, 0)
    for k in (0, 1, 2, 8, 9, 10):
        assert np.linalg.norm(p[k + 1] - o3[k]) == pytest.approx(1.607, abs=0.02)
    loop = table.atom_index[hairpin.loop]
    assert np.isnan(positions[loop[loop >= 0]]).all()


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
