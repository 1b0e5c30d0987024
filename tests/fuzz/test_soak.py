"""Short soaks: calls by number, so that each run makes the same ones."""

import numpy as np
import pytest
import soak
import soak_calls

MOLECULE = frozenset({"find_hairpins", "fold", "scan", "trajectory", "build_atoms"})


def undocumented(seed: int, numbers: range, names: frozenset[str]) -> list[str]:
    """What went wrong in those calls that have one of the names."""
    faults = []
    for number in numbers:
        name = soak_calls.chosen(np.random.default_rng([seed, number]))[0]
        if name not in names:
            continue
        try:
            soak.one_call(seed, number)
        except Exception as error:
            faults.append(f"--seed {seed} --only {number}: {name}: {type(error).__name__}: {error}")
    return faults


def test_calls_on_molecules_end_as_documented():
    assert undocumented(1, range(400), MOLECULE) == []


@pytest.mark.slow
def test_many_calls_on_molecules_end_as_documented():
    assert undocumented(2, range(4000), MOLECULE) == []
