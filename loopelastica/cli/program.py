"""What becomes of errors, interrupts and odd terminals: a sentence and an exit status, for all.

| status | meaning |
|---|---|
| 0 | done |
| 1 | some input cannot be used, or something failed |
| 2 | an argument or an option is wrong |
| 130 | interrupted by Ctrl-C |
"""

import codecs
import errno
import io
import os
import re
import sys
from contextlib import redirect_stderr, suppress
from contextvars import ContextVar
from typing import Any, TextIO, cast

import typer
from typer.core import TyperCommand, TyperGroup

from loopelastica._names import printable

EPILOG = (
    "Exit status: 0 done; 1 some input cannot be used or something failed; 2 an argument or an"
    " option is wrong; 130 interrupted."
)

# options whose names differ from those of the Python arguments; the others are like theirs
_OPTIONS = {
    "extend_3_max": "--extend-3",
    "extend_5_max": "--extend-5",
    "free_spin": "--free-spin",
    "length_per_nucleotide_A": "--length-per-nucleotide",
    "max_candidates": "--candidates",
    "max_size_MB": "--max-size",
    "persistence_length_A": "--persistence-length",
    "rna": "--rna or --dna",
    "strands": "--strand",
    "tapers": "--taper",
}
# what stands for the signs of our tables and sentences where a terminal lacks them
_SIGNS = {
    **{"Å": "A", "·": "*", "′": "'", "–": "-", "−": "-", "…": "...", "±": "+-", "×": "x"},
    **{"°": "deg", "≥": ">=", "≤": "<=", "→": "->", "√": "sqrt", "η": "eta", "ψ": "psi"},
    **{"θ": "theta", "φ": "phi", "χ": "chi", "Ω": "Omega", "κ": "kappa", "τ": "tau"},
}
_LEGIBLE = "loopelastica.legible"
# of the command that runs
_CONTEXT: ContextVar[typer.Context | None] = ContextVar("context", default=None)


class Command(TyperCommand):
    """A command whose errors are one sentence each, and whose options have headings."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments and options of the help, these in their groups."""
        arguments, groups = [], dict[str, list[tuple[str, str]]]()
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is None:
                continue
            if parameter.param_type_name == "argument":
                arguments.append(record)
            else:
                group = getattr(parameter, "rich_help_panel", None) or "Options"
                groups.setdefault(group, []).append(record)
        for heading, records in {"Arguments": arguments, **groups}.items():
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records)

    def invoke(self, ctx: Any) -> Any:
        """Run it; end the program with a status where it cannot be done."""
        from loopelastica.errors import LoopelasticaError

        _CONTEXT.set(ctx)
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as error:
            said = f": {error}" if str(error) else "; no file is left half-written"
            _say_last(f"interrupted{said}")
            raise typer.Exit(130) from None
        except LoopelasticaError as error:
            _say_last(str(error))
        except OSError as error:
            if error.errno == errno.EPIPE:
                raise  # whoever reads has seen enough
            _say_last(_refused(error))
        raise typer.Exit(1)


class Program(TyperGroup):
    """All commands, on a terminal of any encoding."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run a command line."""
        codecs.register_error(_LEGIBLE, _legible)
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors=_LEGIBLE)
        try:
            with redirect_stderr(cast(TextIO, _Diagnostics(sys.stderr))):
                return super().main(*args, **kwargs)
        except OSError as error:
            # of printing a help text; those of a command end there
            say(_refused(error))
            sys.exit(1)


class _Diagnostics:
    """The standard error: sentences and bars are lost where it takes no more, not the work."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write; from the first refusal on to nowhere, else Python fails at its end again."""
        try:
            return self._stream.write(text)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
            return len(text)


def say(sentence: str) -> None:
    """Print a sentence on the standard error, with options as they are called here.

    It is one line, but on a terminal, where it is broken between words.
    """
    text = in_options(sentence)
    lines = [text]
    if sys.stderr.isatty():
        from loopelastica.report.screen.console import width, wrapped

        lines = wrapped(text, width())
    for line in lines:
        tell(line, sys.stderr)


def tell(line: str, file: TextIO | None = None) -> None:
    """Print a line, whatever the names in it are made of; by default on the standard output."""
    # not by echo, which takes it upon itself to send UTF-8 to a terminal of ASCII
    print(printable(line), file=file)


def in_options(sentence: str) -> str:
    """A sentence about `arguments` as one about the --options of the command that runs.

    >>> in_options("`max_candidates` is 0; see `solve`")
    '--candidates is 0; see `solve`'
    """
    return re.sub(r"`(\w+)`", lambda found: _names().get(found[1], found[0]), sentence)


def _names() -> dict[str, str]:
    """Options by the names of their Python arguments."""
    context = _CONTEXT.get()
    if context is None:
        return _OPTIONS
    # what another command says of an option of `fold` is meant for those who go on to that
    commands = getattr(context.find_root().command, "commands", {})
    parameters = [*commands["fold"].params, *context.command.params]
    return {p.name: _shown(p) for p in parameters} | _OPTIONS


def _shown(parameter: Any) -> str:
    """Its longest name: --out rather than -o, FOLDER for an argument."""
    if parameter.param_type_name == "argument":
        return str(parameter.name).upper()
    return str(max(parameter.opts, key=len))


def _legible(error: UnicodeError) -> tuple[str, int]:
    """What stands for signs that a terminal lacks, or that are none, as in odd file names."""
    assert isinstance(error, UnicodeEncodeError)
    signs = error.object[error.start : error.end]
    return "".join(_SIGNS.get(sign) or ascii(sign)[1:-1] for sign in signs), error.end


def _say_last(sentence: str) -> None:
    """Say what has ended the command, in its document too, if that is what it prints."""
    from loopelastica.cli.screen import current

    say(sentence)
    if (screen := current()) is not None:
        with suppress(OSError):
            screen.ended_by(sentence)


def _refused(error: OSError) -> str:
    """Say what the system has refused, and of which file."""
    from loopelastica._files import OutputError

    if error.filename is None and sys.stdout is sys.__stdout__ and sys.stdout is not None:
        # what is left for it goes to nowhere, else Python fails at its end again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sentence = f"{error.filename or 'standard output'}: {error.strerror or error}"
    return str(error) if isinstance(error, OutputError) else sentence
