"""The pages of the documentation: their Python runs and prints what they say."""

import re
import shlex
import warnings
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
import typer.main

from loopelastica.cli.app import app

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGES = sorted(page for page in DOCS.glob("*.md") if "```python" in page.read_text("utf-8"))
# what a page needs beside the package
NEEDED = {"loops": "pandas", "simulation": "openmm"}
# a block of Python, and what it prints where the page says so
_BLOCK = re.compile(r"```python\n(.*?)```(?:\s+```text\n(.*?)```)?", re.S)
_SHELL = re.compile(r"```sh\n(.*?)```", re.S)


@pytest.fixture
def example(tmp_path, monkeypatch):
    """The folder of a reader who has the structure that the pages use."""
    source = DOCS.parent / "data" / "hairpins" / "2koc.pdb"
    (tmp_path / "2koc.pdb").write_bytes(source.read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_python_of_a_page_runs_and_prints_what_it_says(page, example):
    if page.stem in NEEDED:
        pytest.importorskip(NEEDED[page.stem])
    names: dict[str, object] = {}
    for code, expected in _BLOCK.findall(page.read_text("utf-8")):
        printed = StringIO()
        with warnings.catch_warnings(), redirect_stdout(printed):
            # a PDB file has no time between frames, and MDAnalysis says so
            warnings.filterwarnings("ignore", "Reader has no dt information")
            exec(compile(code, page.name, "exec"), names)
        if expected:
            assert printed.getvalue() == expected


def _commands():
    """Every command that a page shows: the page, and its words."""
    for page in sorted(DOCS.rglob("*.md")):
        for block in _SHELL.findall(page.read_text("utf-8")):
            for line in block.splitlines():
                words = shlex.split(line, comments=True)
                names = [n for n, word in enumerate(words) if Path(word).name == "loopelastica"]
                if names:
                    yield page.name, words[names[-1] + 1 :]


@pytest.mark.parametrize(("page", "words"), list(_commands()), ids=str)
def test_every_command_of_the_pages_exists_with_its_options(page, words):
    command = typer.main.get_command(app)
    while hasattr(command, "commands") and words and not words[0].startswith("-"):
        assert words[0] in command.commands
        command, words = command.commands[words[0]], words[1:]
    known = {name for one in command.params for name in (*one.opts, *one.secondary_opts)}
    asked = {word.split("=")[0] for word in words if re.match(r"--?[a-zA-Z]", word)}
    assert asked <= known | {"--help", "-h"}
