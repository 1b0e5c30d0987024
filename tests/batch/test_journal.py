"""The journal survives a kill at any byte, and damage anywhere."""

import json
from pathlib import Path

import pytest

from loopelastica._files import OutputError
from loopelastica.batch.journal import Journal


@pytest.fixture
def path(tmp_path):
    journal = Journal(tmp_path / "journal")
    for k in range(4):
        row = {"rank": k, "folder": f"loop_{k}", "energy": k / 7.0, "stable": None}
        journal.add(f"key{k}", {"rows": [row], "failures": ["Å", "\udcff"]})
    return journal.path


def kept(journal):
    return [k for k in range(4) if f"key{k}" in journal]


def other_types(line):
    """The same record with a field of another type, each in turn."""
    record = json.loads(line)
    for name in ("rows", "failures", "key"):
        for value in (None, 5, "text", {"a": 1}, [3]):
            yield json.dumps(record | {name: value}).encode() + b"\n"
    for name in ("folder", "rank"):
        yield json.dumps(record | {"rows": [{**record["rows"][0], name: [1]}]}).encode() + b"\n"


@pytest.mark.parametrize("place", [0, 1, 2, 3])
def test_a_damaged_line_takes_no_other_with_it(path, place):
    lines = path.read_bytes().splitlines(keepends=True)
    texts = [b"\n", b"noise\n", b"\x00" * 30 + b"\n", b"\xff\xfe\n", b"[" * 100_000 + b"\n"]
    texts += [b"[]\n", b"null\n", b"{}\n", b'{"key": "key1"}\n', lines[place][:-9] + b"\n"]
    # one digit is another one
    texts.append(lines[place].replace(b'"rank": ', b'"rank": 1'))
    texts += other_types(lines[place])
    for text in texts:
        path.write_bytes(b"".join([*lines[:place], text, *lines[place + 1 :]]))
        journal = Journal(path)
        assert kept(journal) == [k for k in range(4) if k != place], text[:80]
        assert journal.damaged == 1
        # what comes after it is read from where it stands, and more can be added
        journal.add(f"key{place}", {"rows": [], "failures": []})
        again = Journal(path)
        assert kept(again) == [0, 1, 2, 3]
        others = [again[f"key{k}"]["rows"][0]["rank"] for k in range(4) if k != place]
        assert others == [k for k in range(4) if k != place]


def test_what_comes_back_is_what_was_kept(path):
    journal = Journal(path)
    assert journal.damaged == 0
    assert [r["rows"][0]["energy"] for r in journal.records([f"key{k}" for k in range(4)])] == [
        k / 7.0 for k in range(4)
    ]
    assert journal["key2"]["failures"] == ["Å", "\udcff"]


def test_a_full_disk_is_told_of_the_journal():
    journal = Journal.__new__(Journal)
    journal.path, journal._begins = Path("/dev/full"), {}
    with pytest.raises(OutputError, match=r"/dev/full: cannot be written \(No space left"):
        journal.add("key", {"rows": [], "failures": []})
    assert "key" not in journal


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
