"""Tables on the screen."""

import dataclasses
import os
from pathlib import Path

import pytest

from loopelastica.report.tables import console, fold_table, hairpins_table


def shown(table):
    terminal = console()
    with terminal.capture() as capture:
        terminal.print(table)
    return capture.get()


@pytest.mark.parametrize("name", ["[red]x", "[/]", "[bold", ":smile:", "a;b"])
def test_a_name_is_shown_as_it_is(fold, name):
    hairpin = dataclasses.replace(fold.hairpin, closing_pair=(name, name))
    loop = dataclasses.replace(fold, hairpin=hairpin)
    text = shown(fold_table([(name, loop, Path(name)), (name, "no loop", None)]))
    assert f"{name}–{name}" in text
    assert text.count(name) == 5


def test_a_name_breaks_no_line_and_no_output(fold):
    names = [("a\nb", r"a\nb"), ("\x1b[2J", r"\x1b[2J"), (os.fsdecode(b"\xff"), r"\udcff")]
    for name, escaped in names:
        text = shown(fold_table([(name, fold, Path(name))]))
        assert text.count(escaped) == 2
        assert text.encode()


def test_so_with_chains_and_what_a_loop_pairs_with():
    hairpin = {
        **{"chain": "[/]", "closing_pair": ["[red]", "b"], "sequence": "CUUCGG", "kind": "RNA"},
        **{"nucleotides": 4, "absent": 0, "stem_pairs": 5, "stem_rms_A": 0.5, "regular": True},
        **{"contacts": [["[/b]", "c"]], "kissing": ["d\ne"]},
    }
    text = shown(hairpins_table([hairpin]))
    for name in ("[/]", "[red]–b", "[/b]–c", "d\\ne"):
        assert name in text
