"""The journal survives a kill at any byte."""

import pytest

from loopelastica.batch.journal import Journal


@pytest.mark.parametrize("cut", [0, 1, 20, 45, 60])
def test_a_cut_line_is_dropped_and_the_rest_kept(tmp_path, cut):
    path = tmp_path / "journal"
    journal = Journal(path)
    for k in range(4):
        journal.add(f"key{k}", {"rows": [{"value": k}], "failures": []})
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) - cut])
    again = Journal(path)
    kept = [k for k in range(4) if f"key{k}" in again]
    assert kept == list(range(4 - -(-cut // (len(whole) // 4))))
    again.add("more", {"rows": [], "failures": ["é"]})
    third = Journal(path)
    assert [third[f"key{k}"]["rows"][0]["value"] for k in kept] == kept
    assert third["more"]["failures"] == ["é"]
    assert [r["key"] for r in third.records(["more", "absent", "key0"])] == ["more", "key0"][
        : 1 + (0 in kept)
    ]
