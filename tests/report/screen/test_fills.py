"""Filled strands on the screen."""

from loopelastica.report.screen.fills import fill_screen

ROW = {
    **{"file": "a.cif.gz", "folder": "a", "model": 1, "chain": "A", "first": "6", "last": "9"},
    **{"sequence": "UUCG", "shape": "rod in its surroundings", "sound": True},
    **{"expected_10_A": 1.2, "expected_rmsd_A": 2.3, "expected_90_A": 4.5, "energy_per_A": 0.0123},
}
REFUSED = {
    **ROW,
    **dict.fromkeys(
        ("expected_10_A", "expected_rmsd_A", "expected_90_A", "energy_per_A", "shape", "sound")
    ),
}


def test_a_strand_has_name_sequence_shape_error_energy_and_soundness(shown):
    lines = shown(*fill_screen([ROW], "out")).splitlines()
    assert "a.cif.gz, in a" in lines
    (line,) = (line for line in lines if "A.6-9" in line)
    assert line.split("  ")[1:4] == ["A.6-9", "UUCG", "rod in its surroundings"]
    assert "2.3 (1.2–4.5)  0.0123    yes" in line


def test_a_refused_strand_is_named(shown):
    text = shown(*fill_screen([REFUSED, {**ROW, "first": "20", "last": "20"}], "out"))
    (line,) = (line for line in text.splitlines() if "A.6-9" in line)
    assert line.endswith("refused")
    assert "A.20  UUCG" in text


def test_a_file_is_named_once_and_a_strand_of_several_models_is_one_row(shown):
    models = [{**ROW, "model": k, "sound": k != 2} for k in (1, 2, 3)]
    text = shown(*fill_screen([*models, {**ROW, "chain": "B"}], "out"))
    assert text.count("a.cif.gz") == 1
    assert text.count("A.6-9") == 1
    assert "2 of 3" in text
    assert "B.6-9" in text


def test_of_hundreds_a_screenful_is_shown_and_the_table_named(shown):
    rows = ({**ROW, "first": str(k)} for k in range(300))
    text = shown(*fill_screen(rows, "out"))
    assert "and 280 more strands: out/summary.csv has all of them" in text
    assert len(text.splitlines()) < 40


def test_long_names_are_broken_and_numbers_are_not(shown):
    long = {**ROW, "file": "x" * 90, "sequence": "ACGU" * 12, "shape": "like 1abc.cif A.4-A.19"}
    assert "2.3 (1.2–4.5)  0.0123" in shown(*fill_screen([long], "out"))
