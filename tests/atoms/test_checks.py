import numpy as np
import pytest

from loopelastica.atoms.checks import check
from loopelastica.atoms.site import site_of


def test_what_is_broken_is_found(koc, fold, models):
    model = models[0]
    site = site_of(koc, fold, koc.positions(0))
    good = model.relaxed.positions_A
    line = np.zeros((4, 3))

    def checked(positions):
        return check(model.molecule, site.geometry, positions, site.around, line, good)

    assert checked(good).sound
    far = good.copy()
    far[model.molecule.index(1, "P")] += 0.3
    assert checked(far).chain_worst_A > 0.05
    assert not checked(far).sound
    mirrored = good * [1.0, 1.0, -1.0]
    assert "1:C1'" in checked(mirrored).wrong_chirality
    close = good.copy()
    shift = site.around[0] - good[model.molecule.index(2, "O2")]
    close[model.molecule.index(2, "O2")] += shift * (1 - 1.0 / np.linalg.norm(shift))
    assert checked(close).closest_A < 1.1
    assert not checked(close).sound


@pytest.mark.parametrize(("share", "wrong"), [(0.45, True), (0.55, False)])
def test_a_sugar_centre_flattened_below_half_its_volume_is_wrong(koc, fold, models, share, wrong):
    """C1' of the first nucleotide, moved towards the plane of its neighbours."""
    model, site = models[0], site_of(koc, fold, koc.positions(0))
    positions = model.relaxed.positions_A.copy()
    centre, *around = (model.molecule.index(0, name) for name in ("C1'", "O4'", "C2'", "N1"))
    a, b, c = positions[around]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    # signed volume of C1' with O4', C2' and N1 in the fibre: 2.45 Å³
    height = share * 2.45 / np.linalg.norm(np.cross(b - a, c - a))
    above = (positions[centre] - a) @ normal
    positions[centre] += (np.copysign(height, above) - above) * normal
    checks = check(
        model.molecule, site.geometry, positions, site.around, np.zeros((4, 3)), positions
    )
    assert ("1:C1'" in checks.wrong_chirality) == wrong
