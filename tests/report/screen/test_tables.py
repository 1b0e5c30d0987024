"""Hairpins, libraries and equilibria on the screen."""

import sys

import numpy as np
import pytest

import loopelastica as le
from loopelastica.report.documents import library_rows
from loopelastica.report.screen.tables import (
    chain_lines,
    equilibria_table,
    hairpins_table,
    library_table,
)


def test_a_chain_of_any_name_and_what_a_loop_pairs_with_are_shown(shown):
    hairpin = {
        **{"chain": "[/]", "closing_pair": ["[red]", "b"], "sequence": "CUUCGG", "kind": "RNA"},
        **{"nucleotides": 4, "absent": 0, "stem_pairs": 5, "stem_rms_A": 0.5, "regular": True},
        **{"contacts": [["[/b]", "c"]], "kissing": ["d\ne"]},
    }
    text = shown(hairpins_table([hairpin]))
    for name in ("[red]–b", "[/b]–c", "kisses d\\ne", "4 nt RNA", "5 pairs", "0.50"):
        assert name in " ".join(text.split())


def test_many_contacts_are_broken_into_lines(shown):
    hairpin = {
        **{
            "chain": "A",
            "closing_pair": ["A.C5", "A.G10"],
            "sequence": "CUUCGG" * 5,
            "kind": "RNA",
        },
        **{"nucleotides": 30, "absent": 2, "stem_pairs": 1, "stem_rms_A": 1.5, "regular": False},
        **{"contacts": [[f"A.U{k}", f"A.A{k + 40}"] for k in range(20)], "kissing": []},
    }
    text = shown(hairpins_table([hairpin]))
    assert "1.50, irregular" in text
    assert "A.U19–A.A59" in text


def test_equilibria_of_tense_and_slack_rods_fit(shown):
    rods = le.equilibria(le.Clamping.from_parameters((-0.4, -0.1, 0.5, 4.8, 1.4, 2.2)))
    text = shown(equilibria_table(rods))
    assert f"{rods[0].energy:.6g}" in text
    assert len(text.splitlines()) == len(rods) + 3
    tense = le.equilibria(le.Clamping.from_parameters((0.2, 0.1, 0.974, 0.3, 0.8, 0.4)), rounds=1)
    assert shown(equilibria_table(tense))


def test_a_library_has_a_row_per_kind_and_length(shown):
    from loopelastica._files import data_path
    from loopelastica.folding.library_file import load_library

    library = load_library(data_path("loops.lib"))
    rows = library_rows(library)
    assert sum(row["loops"] for row in rows) == len(library)
    text = shown(library_table(rows))
    assert text.startswith(f"{len(library)} loop shapes")
    assert len(text.splitlines()) == len(rows) + 3


@pytest.mark.parametrize("length", [40, 80, 203])
def test_long_chains_come_in_blocks_on_a_terminal_and_whole_in_a_pipe(monkeypatch, length):
    rng = np.random.default_rng(4)
    letters = "".join(rng.choice(list("ACGU"), length))
    brackets = "".join(rng.choice(list("(.)"), length))
    chain = {
        **{"chain": "A", "first": "1", "last": str(length)},
        **{"sequence": letters, "dot_bracket": brackets},
    }
    monkeypatch.setenv("COLUMNS", "80")
    assert chain_lines(chain) == [f">A 1-{length}", letters, brackets]
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    _, *lines = chain_lines(chain)
    assert max(map(len, lines)) <= 80
    assert "".join(lines[::2]) == letters
    assert "".join(lines[1::2]) == brackets
