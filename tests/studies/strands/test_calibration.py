import numpy as np
import pytest

from loopelastica.folding.expected import SHIFT_A
from loopelastica.studies.strands.calibration import calibrated, covered


def rows(count=400, entries=20, spread=0.4, seed=1):
    """Strands of three nucleotides whose error comes from the energy alone."""
    rng = np.random.default_rng(seed)
    out = []
    for k in range(count):
        energy = rng.uniform(0.0, 3.0)
        error = 1.5 * np.exp(0.5 * energy + spread * rng.standard_normal()) - SHIFT_A
        out.append(
            {
                "file": f"{k % entries}.cif",
                "class": "3-4",
                "kind": "RNA",
                "type": "junction",
                "signs": [1.0, np.log(3.0), energy, rng.uniform(0, 3), rng.uniform(0.3, 1), 0.0],
                "rmsd_atoms_A": max(error, 0.0),
            }
        )
    return out


def test_the_fit_finds_what_makes_the_error():
    b, quantiles = calibrated(rows())["3-4"]
    assert b[2] == pytest.approx(0.5, abs=0.06)
    assert abs(b[3]) < 0.06
    # quantiles of a normal residual of standard deviation 0.4
    assert quantiles == pytest.approx([-0.513, 0.0, 0.513], abs=0.1)


def test_the_interval_holds_on_entries_that_were_not_seen():
    count, inside, wide = covered(rows())["3-4"]
    assert count == 400
    assert 0.74 < inside < 0.86
    assert wide == pytest.approx(np.exp(2 * 0.513), rel=0.15)


def test_duplexes_of_rna_and_failures_teach_nothing():
    learned = calibrated(rows())
    more = rows(seed=2)
    for row in more[:200]:
        row |= {"type": "helix", "rmsd_atoms_A": 50.0}
    for row in more[200:]:
        del row["rmsd_atoms_A"]
    assert calibrated(rows() + more) == learned


def test_no_strands_no_table():
    assert calibrated([]) == {}
    assert covered([]) == {}


def test_few_entries_teach_nothing():
    assert calibrated(rows(entries=3)) == {}
    assert covered(rows(entries=3)) == {}
