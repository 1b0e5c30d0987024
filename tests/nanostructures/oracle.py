"""The oxDNA2 model in LAMMPS as an oracle; where there is none, tests are skipped."""

import pytest

from loopelastica.errors import MissingDependencyError
from loopelastica.studies.nanostructures import lammps


def _skipping(call, *arguments):
    try:
        return call(*arguments)
    except MissingDependencyError as error:
        pytest.skip(str(error))


def energies(system, folder, temperature=0.1, salt=0.5):
    """Each energy in LAMMPS by its name there, and "bond"; oxDNA's units."""
    return _skipping(lammps.energies, system, folder, temperature, salt)


def run(system, folder, steps):
    """Dynamics with a thermostat from a start at rest; centres (n, 3), potential energy then."""
    ran = _skipping(lammps.run, system, folder, steps)
    return ran.centre, ran.end
