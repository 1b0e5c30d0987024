"""The directive ``commands``: every command with its options, as the program has them today."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import typer.main
from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class Commands(SphinxDirective):
    """A section for each command named (default: all), and for each command of a group."""

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {"except": directives.unchanged}

    def run(self) -> list[nodes.Node]:
        """Make the sections."""
        from loopelastica.cli.app import app

        commands: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
        left_out = self.options.get("except", "").split()
        wanted = [name for line in self.content for name in line.split()]
        if unknown := sorted({*wanted, *left_out} - set(commands)):
            raise self.error(f"no command {', '.join(unknown)}")
        names = wanted or [name for name in commands if name not in left_out]
        return [self.section(commands[name], f"loopelastica {name}") for name in names]

    def section(self, command: Any, name: str) -> nodes.section:
        """What the command is for, how it is called, and its options or its own commands."""
        section = nodes.section(ids=[name.replace(" ", "-")], names=[name])
        section += nodes.title(name, "", nodes.literal(name, name))
        for paragraph in (command.help or "").split("\n\n"):
            section += _text(" ".join(paragraph.split()))
        context = command.context_class(command, info_name=name)
        if own := getattr(command, "commands", None):
            section += [self.section(one, f"{name} {key}") for key, one in own.items()]
            return section
        usage = " ".join([name, *command.collect_usage_pieces(context)])
        section += nodes.literal_block(usage, usage, language="text")
        # None where a parameter is hidden from the help too
        records = [one.get_help_record(context) for one in command.get_params(context)]
        section += _table([record for record in records if record is not None])
        return section


def _table(rows: list[tuple[str, str]]) -> nodes.table:
    """What is typed, and what it means."""
    group, body = nodes.tgroup(cols=2), nodes.tbody()
    group += [nodes.colspec(colwidth=35), nodes.colspec(colwidth=65), body]
    for typed, meaning in rows:
        name = nodes.paragraph("", "", nodes.literal(typed, typed))
        told = _text(re.sub(r"\s+", " ", meaning))
        body += nodes.row("", nodes.entry("", name), nodes.entry("", told))
    return nodes.table("", group)


def _text(sentence: str) -> nodes.paragraph:
    """A paragraph; what stands in backticks is code."""
    paragraph = nodes.paragraph()
    for place, piece in enumerate(sentence.split("`")):
        paragraph += nodes.literal(piece, piece) if place % 2 else nodes.Text(piece)
    return paragraph


def setup(app: Sphinx) -> dict[str, bool]:
    """Give Sphinx the directive."""
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
