"""Tables on the screen."""

import dataclasses
import os
from pathlib import Path

import pytest
from loopelastica.report.tables import atoms_table, console, fold_table, hairpins_table


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


def test_the_table_says_shape_error_and_both_orders(chains):
    text = shown(fold_table([("a", chains, Path("a"))]))
    assert "like 2koc" in text
    assert "straight rod" in text
    assert "1.2 (0.5–2.0)" in text
    assert "measured to be nearest first" in text
    assert "by E" in text


def test_the_title_says_what_the_order_is(chains):
    by_energy = dataclasses.replace(
        chains, options=dataclasses.replace(chains.options, rank="energy")
    )
    assert "least energy first" in shown(fold_table([("a", by_energy, Path("a"))]))


def test_a_shape_is_named_after_a_file_and_breaks_no_line(chains):
    odd = dataclasses.replace(chains.candidates[0], shape="like \x1b[2J\n[red]x")
    text = shown(fold_table([("a", dataclasses.replace(chains, candidates=(odd,)), Path("a"))]))
    assert "\x1b" not in text
    assert r"\x1b[2J" in text
    assert "[red]x" in text


def test_the_table_of_atoms_says_what_is_sound_and_why_others_are_not(atoms):
    first, second = atoms.models
    checks = dataclasses.replace(first.checks, worst_bond_A=0.123, worst_bond="2:O3'–3:P")
    odd = dataclasses.replace(first, checks=checks)
    text = shown(atoms_table([("a.pdb", dataclasses.replace(atoms, models=(odd, second)))]))
    assert "no: bond 2:O3'–3:P off by 0.12 Å" in text
    assert "0.123" in text
    assert "yes" in text
    for figure in (
        f"{second.checks.worst_bond_A:.3f}",
        f"{second.checks.worst_angle_deg:.1f}",
        f"{second.checks.closest_A:.2f}",
        f"{second.rmsd_A:.2f}",
    ):
        assert figure in text
