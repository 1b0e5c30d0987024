"""Short soaks: calls by number, so that each run makes the same ones."""

import pytest
import soak


def undocumented(seed: int, numbers: range) -> list[str]:
    """What went wrong in those calls."""
    faults = []
    for number in numbers:
        try:
            soak.one_call(seed, number)
        except Exception as error:
            faults.append(f"--seed {seed} --only {number}: {type(error).__name__}: {error}")
    return faults


def test_calls_end_as_documented():
    assert undocumented(1, range(200)) == []


@pytest.mark.slow
def test_many_calls_end_as_documented():
    assert undocumented(2, range(600)) == []
