"""Arrays of results."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import loopelastica as le
from loopelastica._arrays import read_only


def test_what_a_result_holds_is_a_copy_that_nobody_writes_to():
    given = np.array([1.0, 2.0])
    kept = read_only(given)
    given[0] = 5.0
    assert kept.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        kept[0] = 5.0
    assert read_only([1, 2]).dtype == np.float64


def arrays_in(value, seen):
    """All arrays that a record holds, however deep."""
    if isinstance(value, np.ndarray):
        yield value
    elif id(value) not in seen:
        seen.add(id(value))
        if dataclasses.is_dataclass(value):
            parts = [getattr(value, item.name) for item in dataclasses.fields(value)]
        else:
            parts = [*value] if isinstance(value, list | tuple) else []
        for part in parts:
            yield from arrays_in(part, seen)


def public_records(koc, fold):
    clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    nearby = le.Clamping.from_parameters([-0.4, -0.1, 0.49, 4.8, 1.4, 2.2])
    rod = le.solve(clamping)
    batch = le.solve_batch([clamping.position] * 2, [clamping.rotation] * 2)
    yield from (clamping, rod, rod.physical, batch, batch[0])
    yield from (le.continue_clamping(rod, nearby), le.twist_end(rod, 0.05))
    yield from (fold, fold.candidates[0], fold.hairpin, koc.nucleotides)
    yield from le.scan(koc, extend_5_max=0, extend_3_max=0, tapers=[0.0])


def test_no_public_record_nor_its_copies_and_pickles_can_be_written_to(koc, fold):
    for record in public_records(koc, fold):
        twins = (
            record,
            copy.copy(record),
            copy.deepcopy(record),
            pickle.loads(pickle.dumps(record)),
        )
        for twin in twins:
            found = list(arrays_in(twin, set()))
            assert not any(array.flags.writeable for array in found), type(record)
        numbers = [len(list(arrays_in(twin, set()))) for twin in twins]
        assert len(set(numbers)) == 1
