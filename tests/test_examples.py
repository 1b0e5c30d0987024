import os
import re
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

# ten clampings instead of thirty show all that the script does
QUICK = {"error_against_time": ("N = 30", "N = 10")}
NEEDED = {"simulate_hairpin": "openmm", "analyse_trajectory": "pandas", "nanostructure": "scadnano"}
EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.py"))
# those that need a program of their own, which the documentation does not run either
RENDERED = [script for script in EXAMPLES if script.stem.startswith("render_")]
GALLERY = [script for script in EXAMPLES if script not in RENDERED]


def run(script, folder, **variables):
    """A script in a process of its own."""
    return subprocess.run(
        [sys.executable, "-W", "error::RuntimeWarning", str(script)],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "MPLBACKEND": "agg", **variables},
    )


@pytest.fixture
def reader(tmp_path, monkeypatch):
    """A reader's folder and settings, where only warnings of wrong numbers are errors."""
    monkeypatch.chdir(tmp_path)
    with plt.rc_context({"backend": "agg"}), warnings.catch_warnings():
        warnings.simplefilter("default")
        warnings.simplefilter("error", RuntimeWarning)
        yield tmp_path
    plt.close("all")


@pytest.mark.parametrize("script", GALLERY, ids=lambda p: p.stem)
def test_each_example_runs_and_draws_its_picture(script, reader, capsys):
    if script.stem in NEEDED:
        pytest.importorskip(NEEDED[script.stem])
    text = script.read_text(encoding="utf-8")
    long, short = QUICK.get(script.stem, ("", ""))
    assert long in text
    # in this process, which has loaded already what each of them imports
    exec(compile(text.replace(long, short), script.name, "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()
    assert (reader / f"{script.stem}.png").stat().st_size > 5000


@pytest.mark.parametrize("script", GALLERY, ids=lambda p: p.stem)
def test_each_example_is_a_page_of_a_gallery(script):
    text = script.read_text(encoding="utf-8")
    head = re.match(r'"""\n([^\n]+)\n(=+)\n\n(.+?)"""\n', text, re.DOTALL)
    assert head, "it begins with a title, underlined, and what it is about"
    assert len(head[1]) == len(head[2])
    assert text.count("\n# %%\n") >= 3
    assert "__file__" not in text, "a gallery runs it without that name"
    assert "matplotlib.use" not in text, "a gallery has a backend of its own"


def test_there_are_eight_subjects_at_least():
    assert len(GALLERY) >= 8


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("pymol"), reason="PyMOL is not installed")
@pytest.mark.parametrize("script", RENDERED, ids=lambda p: p.stem)
def test_a_rendered_molecule_is_a_picture_of_moderate_size(script, tmp_path):
    done = run(script, tmp_path)
    assert done.returncode == 0, done.stderr
    assert 20_000 < (tmp_path / f"{script.stem}.png").stat().st_size < 400_000


@pytest.mark.parametrize("script", RENDERED, ids=lambda p: p.stem)
def test_without_pymol_a_rendering_says_so_in_a_sentence(script, tmp_path):
    done = run(script, tmp_path, PATH=str(tmp_path))
    assert done.returncode != 0
    assert "PyMOL" in done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
