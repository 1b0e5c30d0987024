"""How a command speaks: tables and notes, nothing but failures, or one JSON document.

What is found goes to the standard output and what has failed to the standard error, a sentence in a
line each. With ``--quiet`` there are failures only. With ``--json`` the standard output has one
document and nothing else::

    {"version": "…", "command": "fold", "loops": […], "failures": [{"file": …, "failure": …}],
     "notes": […], "folder": "…"}

The list of results is called ``loops`` (fold, build, scan), ``files`` (fill, hairpins, evaluate),
``equilibria`` (solve), ``kinds`` (library list) or ``tables`` (library build); the modules of the
commands and :mod:`loopelastica.report.documents` say what is in it. A document comes with exit
statuses 0, 1 and 130; an option that is wrong, status 2, leaves the standard output empty.
"""

import logging
from collections.abc import Iterable, Mapping, Sequence
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import typer

from loopelastica._names import printable
from loopelastica.cli.program import in_options, say, tell

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

SHOWN = 20
"""Sentences after which the rest is counted."""

_CURRENT: "ContextVar[Screen | None]" = ContextVar("screen", default=None)


class Screen:
    """What one command says.

    Parameters
    ----------
    command : str
        Its name.
    results : str
        What the list of results is called in its document.
    quiet : bool
        Whether it says nothing but what has failed.
    as_json : bool
        Whether it prints a document.
    """

    def __init__(
        self, command: str, results: str, quiet: bool = False, as_json: bool = False
    ) -> None:
        self.command, self.results, self.as_json = command, results, as_json
        self.quiet = quiet
        self.talks = not (quiet or as_json)
        self.notes: list[str] = []
        if quiet:
            # what the package has to say while it works
            logging.getLogger("loopelastica").setLevel(logging.ERROR)
        _CURRENT.set(self)

    def show(self, *parts: "Table | Text | str") -> None:
        """Print tables, heads and sentences.

        Parameters
        ----------
        *parts : rich.table.Table, rich.text.Text or str
            A string is broken into lines between its words.
        """
        if self.talks:
            show(*parts)

    def lines(self, *lines: str) -> None:
        """Print lines as they are, such as sequences.

        Parameters
        ----------
        *lines : str
        """
        for line in lines if self.talks else ():
            tell(line)

    def note(self, sentences: Iterable[str], rest: str, files: Sequence[str] = ()) -> None:
        """Print what a user should be aware of, alike sentences as one, up to a screenful.

        Parameters
        ----------
        sentences : iterable of str
        rest : str
            Where the others are, such as "in the files' fill.json".
        files : sequence of str
            What the command is about: a single file need not be named again.
        """
        said = [in_options(sentence) for sentence in sentences]
        self.notes += said
        if not self.talks or not said:
            return
        from loopelastica.report.screen.console import SCREENFUL, width, wrapped
        from loopelastica.report.screen.sentences import gathered

        columns, left = width(), SCREENFUL
        known = f"{printable(files[0])}: " if len(files) == 1 else ""
        alike = gathered(sentence.removeprefix(known) for sentence in said)
        for count, sentence in enumerate(alike):
            lines = wrapped(f"note: {sentence}", columns)
            if len(lines) > left and count:
                more = len(alike) - count
                self.show(f"note: {more} more {'note is' if more == 1 else 'notes are'} {rest}")
                return
            left -= len(lines)
            for line in lines:
                tell(line)

    def end(
        self,
        results: Iterable[Any],
        failures: Sequence[Mapping[str, Any]] = (),
        rest: str = "",
        **more: Any,
    ) -> None:
        """Print the document, if one is asked for, and what has failed; status 1 if anything has.

        Parameters
        ----------
        results : iterable
            Of the document.
        failures : sequence of mapping
            ``file`` and ``failure``.
        rest : str
            Where failures beyond a screenful are, such as "in out/failures.csv".
        **more
            Further entries of the document.
        """
        if self.as_json:
            self._print(list(results), failures, more)
        fail([str(failure["failure"]) for failure in failures], rest)

    def _print(
        self, results: list[Any], failures: Iterable[Mapping[str, Any]], more: Mapping[str, Any]
    ) -> None:
        from loopelastica._version import __version__
        from loopelastica.report.documents import json_text

        document = {
            "version": __version__,
            "command": self.command,
            self.results: results,
            "failures": [dict(failure) for failure in failures],
            "notes": self.notes,
            **more,
        }
        typer.echo(json_text(document))

    def ended_by(self, sentence: str) -> None:
        """Print a document that says what has ended the command.

        Parameters
        ----------
        sentence : str
        """
        if self.as_json:
            self._print([], [{"file": None, "failure": in_options(sentence)}], {})


def current() -> Screen | None:
    """That of the command that runs."""
    return _CURRENT.get()


def show(*parts: "Table | Text | str") -> None:
    """Print tables, heads and sentences, the latter broken into lines.

    Parameters
    ----------
    *parts : rich.table.Table, rich.text.Text or str
    """
    from loopelastica.report.screen.console import console, wrapped

    screen = console()
    for part in parts:
        if not isinstance(part, str):
            _print(screen, part)
        elif part.strip():
            for line in wrapped(part, screen.width, ""):
                tell(line)
        else:
            tell("")


def _print(screen: "Console", part: "Table | Text") -> None:
    """Print a table or a head; long words and numbers stay whole whatever the width."""
    if screen.is_terminal:
        screen.print(part, overflow="ignore", crop=False)
        return
    with screen.capture() as capture:
        screen.print(part, overflow="ignore", crop=False)
    for line in capture.get().splitlines():
        print(line.rstrip())


def fail(sentences: Sequence[str], rest: str = "") -> None:
    """Print what failed and exit with status 1; do nothing if nothing failed.

    Parameters
    ----------
    sentences : sequence of str
        One each; those that are alike become one, and no more than twenty are shown.
    rest : str
        Where the others are, such as "in out/failures.csv"; "" where they are nowhere else.
    """
    if not sentences:
        return
    from loopelastica.report.screen.sentences import gathered

    alike = gathered(sentences)
    shown = len(alike) if not rest else SHOWN
    for sentence in alike[:shown]:
        say(sentence)
    if more := len(alike[shown:]):
        say(f"{more} more {rest}")
    raise typer.Exit(1)
