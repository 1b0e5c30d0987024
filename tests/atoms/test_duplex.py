"""The stem: its pairs, its chemistry, its helix."""

import numpy as np
import pytest

from loopelastica.atoms.duplex import HYDROGEN_BONDS, duplex
from loopelastica.atoms.measures import angles_deg, pseudorotation
from loopelastica.atoms.sequence import pair_of, read_sequence
from loopelastica.molecule.strands import ideal_strand, strand_atoms

# Watson and Crick's pairs, and wobbles between each two of their neighbours
STEMS = {
    "Watson–Crick": "GACUC(UUCG)GAGUC",
    "GU after G": "GGGC(UUCG)GUCC",
    "GU after C": "GCGC(UUCG)GUGC",
    "UG after A": "GAUC(UUCG)GGUC",
    "UG after U": "GUUC(UUCG)GGAC",
    "at the end": "GGCU(UUCG)GGCU",
    "tandem": "GGUGC(UUCG)GUGCC",
    "tandem, the other way": "GUGC(UUCG)GUGC",
    "run": "GGUGUGUC(UUCG)GGUGUGUC",
    "all": "GGGGG(UUCG)UUUUU",
}
DNA = {name: text.replace("U", "T") for name, text in STEMS.items()}


def hydrogen_bonds(read, stem, rungs=None):
    """Pair and lengths (Å) of rungs, by default of all."""
    last = len(read.residues) - 1
    for k in range(read.pairs) if rungs is None else rungs:
        pair = pair_of(read.residues[k], read.residues[last - k])
        purine, other = (k, last - k) if read.residues[k].letter in "AG" else (last - k, k)
        here, there = stem.atoms(purine), stem.atoms(other)
        yield (
            pair,
            {
                f"{one}-{two}": float(np.linalg.norm(here[one] - there[two]))
                for one, two, _ in HYDROGEN_BONDS[pair]
            },
        )


@pytest.mark.parametrize("text", [*STEMS.values(), *DNA.values()], ids=[*STEMS, *DNA])
def test_every_pair_has_its_hydrogen_bonds(text):
    read = read_sequence(text)
    ideal = {
        "GC": {"O6-N4": 2.91, "N1-N3": 2.95, "N2-O2": 2.86},
        "AU": {"N6-O4": 2.95, "N1-N3": 2.82},
    }
    for pair, found in hydrogen_bonds(read, duplex(read)):
        if pair == "GU":
            assert all(2.72 < length < 2.95 for length in found.values()), found
            assert set(found) == {"O6-N3", "N1-O2"}
        else:
            assert found == pytest.approx(ideal[pair], abs=0.03)


@pytest.mark.parametrize("text", ["GGC(UUCG)GUC", "GGC(TTTT)GTC"])
def test_a_wobble_is_none_of_watson_and_crick(text):
    stem = duplex(read_sequence(text))
    g, u = stem.atoms(1), stem.atoms(8)
    # medians of crystals; 2.98, 2.78 and 3.03 Å where the fibre is left as it is
    assert np.linalg.norm(g["N1"] - u["N3"]) == pytest.approx(3.60, abs=0.1)
    assert np.linalg.norm(g["O6"] - u["O4"]) == pytest.approx(3.62, abs=0.3)
    assert np.linalg.norm(g["N2"] - u["O2"]) == pytest.approx(3.40, abs=0.3)
    across = np.linalg.norm(g["C1'"] - u["C1'"])
    assert 10.1 < across < 10.7
    # G leans into the minor groove, U out of the major one
    lean = angles_deg(np.array([g["N9"], g["C1'"], u["C1'"], u["N1"]]), np.array([[0, 1, 2]]))
    assert 38.0 < lean[0] < 50.0


@pytest.mark.parametrize("text", [*STEMS.values(), *DNA.values()], ids=[*STEMS, *DNA])
def test_pairs_are_flat(text):
    read = read_sequence(text)
    stem, last = duplex(read), len(read.residues) - 1

    def normal(number):
        at = stem.atoms(number)
        found = np.cross(at["C4"] - at["C2"], at["C6"] - at["C2"])
        return found / np.linalg.norm(found)

    for k in range(read.pairs):
        assert np.rad2deg(np.arccos(abs(normal(k) @ normal(last - k)))) < 20.0


@pytest.mark.parametrize("text", ["GGUAC(UUCG)GUGCC", "GGTAC(TTCG)GTGCC"])
def test_the_helix_stays_next_to_the_fibre(text):
    read = read_sequence(text)
    stem = duplex(read)
    strand = ideal_strand(read.is_dna)
    away = []
    for k in range(1, read.pairs):
        at = stem.atoms(k)
        own = np.array([at[name] for name in ("P", "O5'", "C5'", "C4'", "C3'", "O3'")])
        away.append(np.linalg.norm(own - strand_atoms(strand, k), axis=1))
    assert np.mean(away) < 0.45
    assert np.max(away) < 1.0


@pytest.mark.parametrize(("text", "phase"), [("GGC(UUCG)GUC", 18.0), ("GGC(TTCG)GTC", 162.0)])
def test_sugars_are_those_of_the_helix(text, phase):
    read = read_sequence(text)
    stem = duplex(read)
    for number in (0, 1, 2, 7, 8, 9):
        at = stem.atoms(number)
        ring = (at[name] for name in ("C1'", "C2'", "C3'", "C4'", "O4'"))
        assert pseudorotation(*ring)[0] == pytest.approx(phase, abs=10.0)


@pytest.mark.parametrize("text", [*STEMS.values(), *DNA.values()], ids=[*STEMS, *DNA])
def test_neighbours_leave_room_for_their_hydrogens(text):
    read = read_sequence(text)
    stem, last = duplex(read), len(read.residues) - 1
    for k in (*range(1, read.pairs), *range(last - read.pairs + 2, last + 1)):
        before, at = stem.atoms(k - 1), stem.atoms(k)
        base = at["C8" if read.residues[k].letter in "AG" else "C6"]
        # 3.48 Å in the fibre of RNA, where its H2' would be 1.6 Å from H8 or H6
        least = 3.4 if read.is_dna else 3.7
        assert least < np.linalg.norm(before["C2'"] - base) < 4.3


@pytest.mark.parametrize("text", ["A(TTT)A", "G(UUU)C", "U(UUU)G"])
def test_a_stem_may_have_one_rung(text):
    stem = duplex(read_sequence(text, mismatches=True))
    assert np.isfinite(stem.positions_A).all()


def test_a_stem_of_one_sequence_is_one_stem():
    first, second = (duplex(read_sequence("GGUAC(UUCG)GUGCC")) for _ in range(2))
    assert first.positions_A.tobytes() == second.positions_A.tobytes()


def test_the_5_end_gets_a_phosphate_where_it_is_asked_for():
    read = read_sequence("GGC(UUCG)GCC")
    plain, capped = duplex(read), duplex(read, phosphate=True)
    assert not {"P", "OP1", "OP2", "OP3"} & set(plain.atoms(0))
    at = capped.atoms(0)
    assert np.linalg.norm(at["P"] - at["O5'"]) == pytest.approx(1.593, abs=0.02)
    oxygens = [at[name] for name in ("OP1", "OP2", "OP3")]
    for k, oxygen in enumerate(oxygens):
        assert np.linalg.norm(oxygen - at["P"]) == pytest.approx(1.51, abs=0.01)
        # three equal ones: 112.7° between them
        apart = np.linalg.norm(oxygen - oxygens[k - 1])
        assert apart == pytest.approx(2 * 1.51 * np.sin(np.deg2rad(112.7 / 2)), abs=0.01)
    assert "OP3" not in capped.atoms(1)


@pytest.mark.parametrize(
    "text", ["G[2MG]C(UUCG)GCC", "GA[5MC](UUCG)G[5MU]C", "G[6MZ]C(UUCG)GUC", "G[A2M]C(UUCG)GUC",
             "G[OMG]C(UUCG)G[OMU]C"]
)  # fmt: skip
def test_methyl_groups_leave_the_pairs_alone(text):
    read = read_sequence(text)
    stem = duplex(read)
    ideal = {"GC": [2.91, 2.95, 2.86], "AU": [2.95, 2.82], "GU": [2.86, 2.76]}
    for pair, found in hydrogen_bonds(read, stem):
        assert list(found.values()) == pytest.approx(ideal[pair], abs=0.05)
    for number, residue in enumerate(read.residues):
        if not read.pairs <= number < read.pairs + len(read.loop):
            at = stem.atoms(number)
            for name, carrier in residue.methyls:
                assert 1.3 < np.linalg.norm(at[name] - at[carrier]) < 1.6


@pytest.mark.parametrize(
    ("text", "methyl", "outer", "inner"),
    [("G[2MG]C(UUCG)GCC", "CM2", "N3", "N1"), ("G[6MZ]C(UUCG)GUC", "C9", "C5", "N1")],
)
def test_methyl_groups_of_amines_turn_away_from_the_pair(text, methyl, outer, inner):
    at = duplex(read_sequence(text)).atoms(1)
    away = {name: np.linalg.norm(at[methyl] - at[name]) for name in (outer, inner)}
    assert away[outer] < away[inner] - 0.3


@pytest.mark.parametrize("pair", ["AA", "AC", "AG", "CA", "CC", "CU", "GA", "GG", "UC", "UU"])
@pytest.mark.parametrize("kind", ["RNA", "DNA"])
def test_mismatches_stand_where_they_find_room(pair, kind):
    text = f"GC{pair[0]}GC(UUCG)GC{pair[1]}GC"
    if kind == "DNA":
        text = text.replace("U", "T")
    read = read_sequence(text, mismatches=True)
    stem = duplex(read)
    here, there = (np.array(list(stem.atoms(number).values())) for number in (2, 11))
    assert np.linalg.norm(here[:, None] - there, axis=2).min() > 2.3
    # the pairs next to it are whole
    beside = [list(found.values()) for _, found in hydrogen_bonds(read, stem, (1, 3))]
    assert beside == [pytest.approx([2.91, 2.95, 2.86], abs=0.05)] * 2
