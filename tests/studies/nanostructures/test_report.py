from loopelastica.studies.nanostructures.measures import summed
from loopelastica.studies.nanostructures.report import draw, markdown
from loopelastica.studies.nanostructures.study import RODS, WAYS


def rows():
    own = {
        **dict.fromkeys(("refused", "broken", "drawn_broken", "close", "conflicts"), 0),
        **{"strands": 4, "nucleotides": 10, "bonds": 14, "ready": 3, "backbone": 7.0},
        **{"volume": 5.0, "nearest": 0.7, "skew": 0.0, "largest": 2.0, "seconds": 0.02},
    }
    for way in WAYS:
        whole = 6.0 if way == RODS else None
        total = summed([{"failed": 4}] if way == WAYS[-1] else [own])
        yield {"family": "some", "way": way, "designs": 1, "whole_ms_per_strand": whole, **total}


def test_only_rods_have_a_line_of_their_own_and_the_load_is_said():
    text = markdown(list(rows()), [], [], 1.25)
    rods, ways = text.split("## Beside other lines")
    assert rods.count("| some |") == 1
    assert ways.count("| some |") == len(WAYS)
    assert "load of the machine before: 1.2" in text
    assert "## Dynamics" not in text
    assert "load" not in markdown(list(rows()), [], [], None).split("##")[0]


def test_a_run_that_failed_has_dashes_for_figures():
    moved = [{"family": "some", "way": RODS, "nucleotides": 9, "steps": 5, "outcome": "ERROR"}]
    line = markdown(list(rows()), [], moved, None).splitlines()[-1]
    assert line == f"| some | {RODS} | 9 | 5 | – | – | – | ERROR |"


def test_round_trips_are_summed_by_the_form_of_the_topology():
    trip = {"form": "old", "paired": 6, "lost": 1, "changed": 2, "broken": 0, "close": 0}
    trips = [trip, trip, {**trip, "form": "new", "lost": 0}]
    lines = markdown(list(rows()), trips, [], None).splitlines()
    assert "| old | 2 | 12 | 2 | 4 | 0 | 0 |" in lines
    assert "| new | 1 | 6 | 0 | 2 | 0 | 0 |" in lines


def test_a_way_without_times_has_no_point_and_the_picture_is_drawn(tmp_path):
    draw(list(rows()), tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
