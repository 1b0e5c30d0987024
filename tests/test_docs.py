"""The pages of the documentation: their Python runs and prints what they say."""

import re
import shlex
import subprocess
import sys
import warnings
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
import typer.main

import loopelastica as le
from loopelastica.cli.app import app

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGES = sorted(page for page in DOCS.glob("*.md") if "```python" in page.read_text("utf-8"))
# what a page needs beside the package
NEEDED = {"loops": "pandas", "nanostructures": "scadnano", "simulation": "openmm"}
# a block of Python, and what it prints where the page says so
_BLOCK = re.compile(r"```python\n(.*?)```(?:\s+```text\n(.*?)```)?", re.S)
_LINK = re.compile(r"\]\(([^)#:\s]+\.(?:md|png|svg|py))(?:#[^)]*)?\)")
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


def test_the_reference_has_every_public_name_once():
    text = (DOCS / "api" / "index.rst").read_text("utf-8")
    listed = re.findall(r"^   ([A-Za-z_]\w*)$", text, re.M)
    assert sorted(listed) == sorted(set(le.__all__) - {"__version__"})


def test_the_pages_link_only_to_files_that_are_there():
    for page in sorted(DOCS.rglob("*.md")):
        if "_build" in page.parts:
            continue
        for target in _LINK.findall(page.read_text("utf-8")):
            assert (page.parent / target).is_file(), f"{page.name}: {target}"


@pytest.mark.slow
def test_the_documentation_builds_without_a_warning(tmp_path):
    pytest.importorskip("sphinx_gallery")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-D", "plot_gallery=0"]
    done = subprocess.run(
        [*command, "-d", tmp_path / "trees", DOCS, tmp_path / "html"],
        capture_output=True, text=True, cwd=DOCS.parent,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    # nothing is fetched when a page is read
    page = (tmp_path / "html" / "rods.html").read_text("utf-8")
    assert not re.search(r"<(?:script|link|img)[^>]+(?:src|href)=\"https?://", page)
