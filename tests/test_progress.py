"""Progress bars are for terminals."""

import io
import sys

import pytest

from loopelastica._progress import progress_bar


class Stream(io.StringIO):
    def __init__(self, terminal):
        super().__init__()
        self.terminal = terminal

    def isatty(self):
        return self.terminal


@pytest.mark.parametrize(
    ("terminal", "shown", "seen"), [(True, True, True), (True, False, False), (False, True, False)]
)
def test_a_bar_is_seen_on_a_terminal_where_it_is_wanted(monkeypatch, terminal, shown, seen):
    monkeypatch.setattr(sys, "stderr", Stream(terminal))
    assert list(progress_bar([1, 2, 3], shown=shown)) == [1, 2, 3]
    assert bool(sys.stderr.getvalue()) == seen
