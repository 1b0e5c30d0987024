"""Short soaks: calls that are drawn by number, so that each run makes the same ones."""

import soak
import soak_calls


def undocumented(seed: int, numbers: range, names: set[str]) -> list[str]:
    """What went wrong in those calls that have one of the names."""
    import numpy as np

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


MOLECULE = {"find_hairpins", "fold", "scan", "trajectory"}
