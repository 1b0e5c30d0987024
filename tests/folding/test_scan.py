"""All clamps of a stem, ranked."""

import numpy as np
import pytest
from typer.testing import CliRunner

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.cli.app import app

HAIRPIN = data_path("hairpins/2koc.pdb")


@pytest.fixture(scope="module")
def scanned():
    (loop,) = le.scan(HAIRPIN)
    return loop


def test_every_feasible_clamp_is_there_and_the_rules_is_marked(scanned):
    clamps = {
        (c.ends.clamp.stem_extend_5, c.ends.clamp.stem_extend_3, c.ends.clamp.taper)
        for c in scanned.candidates
    }
    assert {(0, 0, 0.0), (0, 0, 0.2), (1, 0, 0.0), (2, 0, 0.2)} <= clamps
    assert all(c.ends.distance_A < c.ends.length_A for c in scanned.candidates)
    assert all(c.ends.n_free >= 2 for c in scanned.candidates)
    (first, *_) = (c for c in scanned.candidates if c.is_rule)
    (loop,) = le.fold(HAIRPIN, all_models=False, shapes="rod")
    np.testing.assert_array_equal(first.candidate.trace, loop.candidates[0].trace)


def test_the_two_orders_are_those_of_E_and_E_times_L(scanned):
    free = [c for c in scanned.candidates if not c.candidate.contacts.touching]
    assert [c.candidate.rank for c in scanned.candidates] == list(
        range(1, len(scanned.candidates) + 1)
    )
    energies = [c.candidate.energy_per_A for c in free]
    assert energies == sorted(energies)
    by_el = [c.candidate.rod.energy for c in sorted(free, key=lambda c: c.rank_by_EL)]
    assert by_el == sorted(by_el)
    for c in free:
        assert c.candidate.energy_per_A * c.ends.length_A == pytest.approx(c.candidate.rod.energy)
    assert scanned.spread_A > 0.5


def test_a_scan_that_cannot_be_is_refused(hairpin_folder):
    with pytest.raises(ValueError, match="tapers"):
        le.scan(HAIRPIN, tapers=[0.9])
    with pytest.raises(ValueError, match="extend_5_max"):
        le.scan(HAIRPIN, extend_5_max=-1)
    (loop,) = le.scan(hairpin_folder / "1d16.pdb.gz", extend_5_max=0, extend_3_max=0)
    assert "no A or B helix" in loop.failure
    assert loop.candidates == ()
    (irregular,) = le.scan(
        hairpin_folder / "1d16.pdb.gz", extend_5_max=0, extend_3_max=0, irregular=True
    )
    assert irregular.failure is None
    assert irregular.candidates


def test_a_scan_takes_loops_that_are_named():
    (wider,) = le.scan(HAIRPIN, extend_5_max=0, extend_3_max=0, tapers=[0.0], loop="A.5-10")
    assert wider.hairpin.closing_pair == ("A.A4", "A.U11")
    arguments = ["scan", str(HAIRPIN), "--extend-5", "0", "--extend-3", "0", "--taper", "0"]
    result = CliRunner().invoke(app, [*arguments, "--loop", "A.5-10"])
    assert result.exit_code == 0
    assert "for 6 nucleotides" in " ".join(result.output.split())


def test_the_command_says_what_error_to_expect_and_that_energy_is_no_confidence():
    arguments = ["scan", str(HAIRPIN), "--extend-5", "1", "--extend-3", "0", "--taper", "0.2"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0
    text = " ".join(result.output.split())
    assert "Energy is no confidence" in text
    assert "1.9 Å (median), 3.6 Å (90 %)" in text
    assert CliRunner().invoke(app, ["scan", "absent.pdb"]).exit_code == 1
    assert CliRunner().invoke(app, ["scan", str(HAIRPIN), "--taper", "2"]).exit_code == 2


def test_the_spread_is_that_of_the_lowest_shapes_of_small_extensions(scanned):
    lowest = {}
    for c in scanned.candidates:
        clamp = c.ends.clamp
        if clamp.stem_extend_5 <= 1 and clamp.stem_extend_3 <= 2:
            lowest.setdefault(clamp, c.candidate.trace)
    assert {(c.stem_extend_5, c.stem_extend_3) for c in lowest} >= {(0, 2), (1, 1)}
    traces = np.array(list(lowest.values()))
    away = np.linalg.norm(traces - traces.mean(axis=0), axis=2)
    assert scanned.spread_A == pytest.approx(np.sqrt((away**2).mean()))
