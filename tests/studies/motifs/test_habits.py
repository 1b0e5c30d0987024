import numpy as np
import pytest

from loopelastica.studies.motifs.habits import fitted


def test_the_fit_finds_the_terms_that_made_the_data(rng):
    terms = np.column_stack([np.ones(4000), rng.integers(0, 2, (4000, 2))])
    true = np.array([-1.0, 1.5, -0.5])
    has = (rng.random(4000) < 1.0 / (1.0 + np.exp(-terms @ true))).astype(float)
    assert fitted(terms, has, np.ones(4000)) == pytest.approx(true, abs=0.25)


def test_weights_count_as_copies(rng):
    terms = np.column_stack([np.ones(60), rng.integers(0, 2, 60)])
    has = rng.integers(0, 2, 60).astype(float)
    twice = fitted(np.repeat(terms, 2, axis=0), np.repeat(has, 2), np.ones(120))
    assert fitted(terms, has, np.full(60, 2.0)) == pytest.approx(twice, abs=1e-4)
