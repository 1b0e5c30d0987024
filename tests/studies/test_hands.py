import numpy as np
import pytest

from loopelastica.atoms.fibre import fibre_nucleotide
from loopelastica.studies.hands import wrong_hands


@pytest.mark.parametrize(("letter", "is_dna", "centres"), [("G", False, 4), ("T", True, 3)])
def test_hands_of_the_fibre_are_right_and_of_its_mirror_image_wrong(letter, is_dna, centres):
    atoms = fibre_nucleotide(letter, is_dna)
    assert wrong_hands(atoms) == 0
    mirrored = {name: at * np.array([1.0, 1.0, -1.0]) for name, at in atoms.items()}
    assert wrong_hands(mirrored) == centres


def test_a_flattened_centre_is_wrong_and_one_without_neighbours_is_not_counted():
    atoms = dict(fibre_nucleotide("A", False))
    around = [atoms[name] for name in ("C4'", "C2'", "O3'")]
    atoms["C3'"] = np.mean(around, axis=0)
    assert wrong_hands(atoms) >= 1
    assert wrong_hands({"C3'": atoms["C3'"]}) == 0
