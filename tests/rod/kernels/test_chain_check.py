import numpy as np
import pytest
from chains import clamping_near, shape_drawn

from loopelastica.rod.kernels.chain import new_chain, set_shape
from loopelastica.rod.kernels.chain_check import judge
from loopelastica.rod.kernels.rotations import quaternion_from_matrix

# kernels that Python does not call otherwise are compiled one by one
pytestmark = pytest.mark.slow


@pytest.fixture(params=[False, True])
def verdict(rng, request):
    """From what is changed of a good solution to the check's verdict."""
    shape = shape_drawn(rng, 6, varied=False)
    deformed = shape.deform(clamping_near(rng, shape, free_spin=request.param), 0.6)
    assert deformed.converged
    chain = new_chain(6)
    end = shape.end_frame.copy()
    set_shape(chain, shape.steps.copy(), quaternion_from_matrix(end), shape.stiffness.copy(), 0.6)
    good = {
        "force": deformed.force.copy(),
        "position": deformed.clamping.position.copy(),
        "energy": deformed.energy,
        "nodes": 3.0 * deformed.nodes,
        "rotations": np.concatenate([deformed.rotations[1:-1], deformed.end_frame[None]]),
    }

    def of(**changed):
        values = good | changed
        moment = np.empty(3)
        found = judge(
            chain, values["force"], values["position"], request.param, values["energy"], 3.0, end,
            values["nodes"], values["rotations"], moment,
        )  # fmt: skip
        if not changed:
            np.testing.assert_allclose(moment, deformed.moment, atol=1e-12)
        return found

    return of, good


def test_a_solution_passes_and_each_part_that_is_wrong_is_noticed(verdict):
    of, good = verdict
    assert of() < 1e-9
    wrong = 1e-4
    assert of(force=good["force"] + wrong) > 1e-7
    assert of(position=good["position"] + wrong) > 1e-5
    assert of(energy=good["energy"] + wrong) > 1e-6
    nodes = good["nodes"].copy()
    nodes[3] += wrong
    assert of(nodes=nodes) > 1e-7
    c, s = np.cos(wrong), np.sin(wrong)
    for k in range(7):
        rotations = good["rotations"].copy()
        rotations[k] = rotations[k] @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        assert of(rotations=rotations) > 1e-7
    assert np.isnan(of(energy=np.nan))
