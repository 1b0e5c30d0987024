import numpy as np
import pytest

from loopelastica.errors import MissingDependencyError
from loopelastica.nanostructures.oxdna.energies import energies
from loopelastica.studies.nanostructures import lammps
from loopelastica.studies.nanostructures.starts import chord, on_curves


@pytest.fixture
def pin(laid):
    """A small hairpin, where there is a LAMMPS to run it."""
    try:
        lammps.program().close()
    except MissingDependencyError as error:
        pytest.skip(str(error))
    return laid("many-hairpins", 0, 1)[1]


def test_a_run_begins_with_the_energy_of_the_start_and_does_not_blow_up(pin, tmp_path):
    ran = lammps.run(pin.system, tmp_path, 400)
    n = len(pin.system)
    # ends of strands have half charges here, and whole ones in LAMMPS
    assert ran.begin == pytest.approx(sum(energies(pin.system).values()), abs=0.05)
    assert ran.highest >= max(ran.begin, ran.end)
    # six degrees of freedom take kT/2 each
    assert ran.end < ran.begin + 3 * n * 0.1
    assert 0 < ran.hottest < 0.3
    assert np.abs(ran.centre - pin.system.centre).max() < 5


def test_a_broken_start_is_an_error_and_leaves_the_process_alive(pin, laid, tmp_path):
    # a loop of sixty on a straight chord
    _, found = laid("hairpins", 0, 2)
    start = on_curves(found.system, found.strands, chord)
    with pytest.raises(Exception, match="ERROR"):
        lammps.run(start, tmp_path, 400)
    assert np.isfinite(lammps.run(pin.system, tmp_path, 10).end)
