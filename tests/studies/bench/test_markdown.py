"""Tables in markdown."""

from loopelastica.studies.bench.markdown import markdown_table


def test_what_is_missing_is_a_dash():
    rows = [{"a": 1.5, "b": "x"}, {"a": None}]
    assert markdown_table(rows, {"a": ("A", ".2f"), "b": ("B", "")}).splitlines() == [
        "| A | B |",
        "|---:|---:|",
        "| 1.50 | x |",
        "| – | – |",
    ]
