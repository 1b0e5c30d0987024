from dataclasses import replace

import numpy as np
import pytest

from loopelastica.studies.nanostructures import round_trips as trips
from loopelastica.studies.nanostructures.designs import drawn

WHOLE = {"lost": 0, "changed": 0, "topology": True, "broken": 0, "close": 0}


@pytest.fixture
def path(tmp_path, family):
    """Files of designs by their families."""
    pytest.importorskip("scadnano")

    def write(key):
        path = tmp_path / f"{key}.sc"
        path.write_text(drawn(family(key), 0, 3, 6).to_json())
        return path

    return write


def test_paired_nucleotides_keep_their_lines_and_partners_in_both_forms(path):
    rows = trips.round_trips([path("hairpins"), path("tails")])
    assert [(row["design"], row["form"]) for row in rows] == [
        (f"{key}.sc", form) for key in ("hairpins", "tails") for form in ("old", "new")
    ]
    for row in rows:
        assert row["paired"] > 20
        assert {name: row[name] for name in WHOLE} == WHOLE


def test_lines_that_change_and_pairs_that_are_lost_are_counted(path, monkeypatch):
    read = trips.nanostructure

    def altered(file):
        found = read(file)
        if file.suffix == ".sc":
            return found
        centre, pair = found.system.centre.copy(), found.system.pair.copy()
        moved, lost = np.flatnonzero(pair >= 0)[:2]
        centre[moved] += 0.5
        pair[[lost, pair[lost]]] = -1
        return replace(found, system=replace(found.system, centre=centre, pair=pair))

    monkeypatch.setattr(trips, "nanostructure", altered)
    rows = trips.round_trips([path("hairpins")])
    assert [(row["changed"], row["lost"]) for row in rows] == [(1, 2), (1, 2)]


def test_designs_with_refused_strands_have_no_files_and_no_rows(path):
    assert trips.round_trips([path("spacers")]) == []
