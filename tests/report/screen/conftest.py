"""What is shown, as text."""

import pytest
from rich.cells import cell_len

from loopelastica.cli.screen import show


@pytest.fixture
def shown(capsys, monkeypatch):
    """What parts look like on a screen of so many columns; nothing in it may be cut."""

    def of(*parts, columns=80):
        monkeypatch.setenv("COLUMNS", str(columns))
        show(*parts)
        text = capsys.readouterr().out
        assert "…" not in text
        assert all(cell_len(line) <= columns for line in text.splitlines()), text
        return text

    return of
