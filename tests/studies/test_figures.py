"""Figures that are written without a window."""

import pytest

from loopelastica.studies.figures import new_figure, save_figure


def test_a_figure_is_a_png_of_the_size_requested(tmp_path):
    figure = new_figure(2.0, 1.0)
    figure.add_subplot().plot([0, 1], [1, 0])
    save_figure(figure, tmp_path / "new" / "a.png", dpi=50)
    content = (tmp_path / "new" / "a.png").read_bytes()
    assert content.startswith(b"\x89PNG")
    assert [int.from_bytes(content[k : k + 4], "big") for k in (16, 20)] == [100, 50]


def test_an_error_leaves_the_figure_that_was_there(tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(b"before")

    class Broken:
        def savefig(self, part, dpi):
            part.write_bytes(b"half")
            raise OSError("no space left on device")

    with pytest.raises(OSError, match="space"):
        save_figure(Broken(), path)
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]
