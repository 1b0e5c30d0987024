from dataclasses import replace

import numpy as np
import pytest

from loopelastica.nanostructures.oxdna.energies import energies
from loopelastica.studies.nanostructures.measures import measured, summed


def test_a_start_without_faults_is_ready(laid):
    _, found = laid("hairpins", 0, 4)
    row = measured(found.system, found.strands)
    n = sum(map(len, found.strands))
    assert (row["strands"], row["ready"], row["nucleotides"]) == (4, 4, n)
    assert row["bonds"] == n + 4
    assert (row["broken"], row["close"], row["conflicts"], row["refused"]) == (0, 0, 0, 0)
    assert row["skew"] < 1e-12
    assert row["nearest"] is None or row["nearest"] > 0.4


def test_energies_are_those_of_the_model_without_the_helices(laid):
    _, found = laid("linkers", 1, 3)
    system = found.system
    row = measured(system, found.strands)
    whole = energies(system)
    helices = energies(replace(system, placed=system.placed & (system.pair >= 0)))
    for own, names in (
        ("backbone", ["backbone"]),
        ("volume", ["bonded_excluded_volume", "nonbonded_excluded_volume"]),
    ):
        difference = sum(whole[name] - helices[name] for name in names)
        assert row[own] == pytest.approx(difference, abs=1e-9)


def test_each_fault_is_counted_with_its_strand(laid):
    _, found = laid("hairpins", 0, 4)
    centre = found.system.centre.copy()
    broken, close = (one.nucleotides for one in found.strands[1:3])
    centre[broken[1]] += 5.0
    centre[close[0]] = centre[close[-1]] + 0.1
    system = replace(found.system, centre=centre)
    row = measured(system, found.strands)
    assert row["ready"] == 2
    assert row["close"] >= 1
    assert row["nearest"] == pytest.approx(np.sqrt(0.03))
    assert row["broken"] >= 2
    turned = replace(found.system, a1=1.1 * found.system.a1)
    assert measured(turned, found.strands)["skew"] > 0.1


def test_refused_strands_are_counted_apart(laid):
    _, found = laid("spacers", 0, 30)
    assert found.refused
    row = measured(found.system, found.strands)
    assert row["refused"] == len(found.refused)
    assert row["strands"] == len(found.strands) - len(found.refused)


def test_a_family_has_sums_and_extremes_and_what_failed_lowers_the_share():
    row = {
        **dict.fromkeys(("refused", "broken", "drawn_broken", "close", "conflicts"), 0),
        **{"strands": 4, "nucleotides": 10, "bonds": 14, "ready": 3, "backbone": 7.0},
        **{"volume": 5.0, "nearest": 0.7, "skew": 0.0, "largest": 2.0, "seconds": 0.02},
    }
    total = summed([row, {**row, "nearest": 0.5, "largest": 9.0}, {"failed": 2}])
    assert (total["strands"], total["failed"]) == (8, 2)
    assert (total["nearest"], total["largest"]) == (0.5, 9.0)
    assert total["ready_share"] == pytest.approx(0.6)
    assert total["ms_per_strand"] == pytest.approx(5.0)
    assert total["backbone_per_bond"] == pytest.approx(0.5)
    assert total["volume_per_nucleotide"] == pytest.approx(0.5)


def test_where_nothing_was_laid_there_are_no_shares():
    total = summed([{"failed": 3}])
    assert total["ready_share"] == 0
    for name in ("ms_per_strand", "backbone_per_bond", "volume_per_nucleotide", "nearest"):
        assert total[name] is None
