"""The width of the screen, and what is broken to fit it."""

import io
import sys

import pytest

from loopelastica.report.screen.console import WIDTH, add_row, new_table, width, wrapped


def test_a_pipe_has_eighty_columns_unless_columns_says_another_number(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setattr(sys, "stdout", io.StringIO())
    assert width() == WIDTH == 80
    monkeypatch.setenv("COLUMNS", "132")
    assert width() == 132


@pytest.mark.parametrize("columns", ["", "x", "0", "-3", "1.5"])
def test_columns_that_are_no_number_count_for_nothing(monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    assert width(terminal=False) == 80


def test_a_terminal_has_its_own_width(monkeypatch):
    import os

    class Terminal(io.StringIO):
        def fileno(self):
            return 1

        def isatty(self):
            return True

    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setattr(sys, "stdout", Terminal())
    monkeypatch.setattr(os, "get_terminal_size", lambda _: os.terminal_size((104, 30)))
    assert width() == 104


def test_a_very_narrow_screen_cuts_no_number(monkeypatch):
    monkeypatch.setenv("COLUMNS", "10")
    assert width() == 60


def test_a_long_word_is_no_reason_to_break_it():
    path = "/a/" + "long/" * 30 + "file.pdb"
    lines = wrapped(f"note: {path}: there is no loop", 40)
    assert lines[1].strip() == f"{path}:"
    assert max(map(len, [lines[0], *lines[2:]])) <= 40


def test_numbers_stay_whole_where_words_are_broken(shown):
    table = new_table(["shape"], ["expected", "energy"])
    add_row(table, "a shape with a long name " * 5, "12.5 (10.1–20.3)", "0.1234")
    text = shown(table, columns=60)
    assert "12.5 (10.1–20.3)  0.1234" in text


@pytest.mark.parametrize("name", ["[red]x", "[/]", ":smile:", "a\tb"])
def test_a_name_is_no_markup(shown, name):
    table = new_table(["name"], [])
    add_row(table, name)
    assert name.replace("\t", r"\t") in shown(table)
