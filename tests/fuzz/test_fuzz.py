"""Files with faults at random, by number: each run makes the same ones."""

import fuzz
import pytest


def test_files_with_faults_are_folded_or_refused_in_one_line(tmp_path):
    outcomes, faults = fuzz.fuzz(1, range(150), tmp_path)
    assert not faults, "\n".join(faults)
    # the faults are neither too coarse nor too fine
    assert min(outcomes["folded"], outcomes["refused"]) > 15


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3, 4])
def test_many_files_with_faults_are_folded_or_refused_in_one_line(tmp_path, seed):
    _, faults = fuzz.fuzz(seed, range(200), tmp_path)
    assert not faults, "\n".join(faults)


def test_a_file_is_the_same_at_every_call():
    assert [fuzz.case(5, k) for k in range(20)] == [fuzz.case(5, k) for k in range(20)]
