"""Reports in Markdown on the screen."""

from loopelastica.report.screen.markdown import markdown_screen


def report(columns):
    head = "| case | " + " | ".join(f"figure {k}" for k in range(columns)) + " |"
    rule = "|---|" + "---:|" * columns
    row = "| tense and twisted | " + " | ".join(f"{k}.25e-7" for k in range(columns)) + " |"
    return "\n".join(["# What was measured", "", "A sentence " * 12, "", head, rule, row, ""])


def test_headings_sentences_and_tables_are_shown_without_their_signs(shown):
    text = shown(*markdown_screen(report(3)))
    assert text.startswith("What was measured\n")
    assert "|" not in text
    assert "#" not in text
    for word in ("tense and twisted", "figure 2", "0.25e-7", "2.25e-7"):
        assert word in text


def test_a_wide_table_goes_on_below_with_its_first_column(shown):
    text = shown(*markdown_screen(report(14)))
    assert text.count("tense and") == 3
    for k in range(14):
        assert text.count(f" {k}.25e-7") == 1


def test_pictures_are_left_out(shown):
    assert shown(*markdown_screen("before\n![x](a.png)\nafter")) == "before\nafter\n"
