import os
import subprocess
import sys
from pathlib import Path

import pytest

# the full run takes a quarter of an hour
QUICK = {"simulate_hairpin": {"PICOSECONDS": "0.4"}}
NEEDED = {"simulate_hairpin": "openmm"}
EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda p: p.stem)
def test_each_example_runs_and_draws_its_picture(script, tmp_path):
    if script.stem in NEEDED:
        pytest.importorskip(NEEDED[script.stem])
    done = subprocess.run(
        [sys.executable, "-W", "error::RuntimeWarning", str(script)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, **QUICK.get(script.stem, {})},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    assert (tmp_path / f"{script.stem}.png").stat().st_size > 5000


def test_there_are_examples():
    assert EXAMPLES
