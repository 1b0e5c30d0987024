"""Refusals that commands share."""

from pathlib import Path

import pytest
import typer

from loopelastica.cli.options import fail_of_many


@pytest.mark.parametrize(("n", "last"), [(20, "file 19"), (21, "1 more in out/failures.csv")])
def test_a_screenful_of_failures_is_shown_and_the_rest_counted(capsys, n, last):
    with pytest.raises(typer.Exit):
        fail_of_many([f"file {k}" for k in range(n)], Path("out"))
    lines = capsys.readouterr().err.splitlines()
    assert lines[:20] == [f"file {k}" for k in range(20)]
    assert lines[-1] == last
    assert len(lines) == n


def test_no_failure_ends_no_program(capsys):
    fail_of_many([], Path("out"))
    assert capsys.readouterr().err == ""
