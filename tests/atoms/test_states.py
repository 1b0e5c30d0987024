import numpy as np
import pytest

from loopelastica.atoms.carry import IdealCurve
from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.atoms.geometry import CHIRALITY
from loopelastica.atoms.measures import chi_torsion, pseudorotation, torsion_deg
from loopelastica.atoms.states import SYN, SYN_CHI_DEG, chi_changes, place, states_on
from loopelastica.molecule.strands import ideal_strand

RING = ("C1'", "C2'", "C3'", "C4'", "O4'")
KINDS = [("A", False), ("C", False), ("G", False), ("U", False),
         ("A", True), ("C", True), ("G", True), ("T", True)]  # fmt: skip


def line(is_dna):
    return IdealCurve(ideal_strand(is_dna), np.eye(3), np.zeros(3))


@pytest.mark.parametrize(("letter", "is_dna"), KINDS)
def test_half_of_the_states_have_either_pucker_and_a_quarter_is_syn(letter, is_dna):
    states = states_on(letter, is_dna, line(is_dna), 1)
    assert len(states) == 192
    assert states.c2_endo.sum() == 96
    assert states.syn.sum() == 48
    for row in range(0, len(states), 17):
        at = dict(zip(states.names, states.atoms[row], strict=True))
        phase, _ = pseudorotation(*(at[name] for name in RING))
        assert (90.0 < phase < 270.0) == states.c2_endo[row]
        chi = torsion_deg(*(at[name] for name in chi_torsion(letter)))
        assert (abs(chi) < 90.0) == states.syn[row]
        if states.syn[row]:
            assert chi == pytest.approx(SYN_CHI_DEG, abs=1e-6)


@pytest.mark.parametrize(("letter", "is_dna"), KINDS)
def test_the_other_pucker_has_the_same_atoms_with_the_same_hands(letter, is_dna):
    own, other = fibre_nucleotide(letter, is_dna), fibre_nucleotide(letter, is_dna, not is_dna)
    assert list(own) == list(other)
    base = chi_torsion(letter)[2]
    for centre, names, _ in CHIRALITY[:4]:
        quad = [centre, *(base if name == "base" else name for name in names)]
        if all(name in own for name in quad):
            volumes = []
            for atoms in (own, other):
                a, b, c, d = (atoms[name] for name in quad)
                volumes.append((b - a) @ np.cross(c - a, d - a))
            assert min(volumes) > 1.5, (centre, volumes)
    if "O2'" in other:
        assert np.linalg.norm(other["O2'"] - other["C2'"]) == pytest.approx(1.41, abs=0.06)


def test_a_state_is_what_place_lays_there():
    states = states_on("G", False, line(False), 1)
    for row in (5, 77, 100, 190):
        change = chi_changes("G", False, bool(states.c2_endo[row]))[states.chi_class[row]]
        at = place("G", False, line(False), 1, states.omega_deg[row], change,
                   bool(states.c2_endo[row]))  # fmt: skip
        np.testing.assert_allclose(list(at.values()), states.atoms[row], atol=1e-9)
    assert len(states.take(np.array([3, 4]))) == 2
    assert chi_changes("G", False, True)[SYN] != chi_changes("G", False, False)[SYN]
