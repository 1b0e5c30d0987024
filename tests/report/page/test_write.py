"""The page of a folder of results: one file that needs no network and harms nobody."""

import base64
import copy
import gzip
import json
import re

import pytest

import loopelastica as le
from loopelastica.errors import LoopelasticaError, MissingDependencyError
from loopelastica.report.page.scene import read_scene, write_scene
from loopelastica.report.page.write import PAGE, renew_report, write_report

pytest.importorskip("plotly")
# what the page's script reads, and plotly's script
REPORT = re.compile(r"<script>window\.report = (.*);</script>\n")
PLOTLY = re.compile(r'<script type="text/plain" id="plotly">([A-Za-z0-9+/=]*)</script>')


def content(page):
    return json.loads(REPORT.search(page.read_text(encoding="utf-8"))[1])


@pytest.fixture
def two(tmp_path, make_run):
    return make_run(tmp_path / "out", ["B1", "A1"])


def test_the_page_has_a_row_per_loop_in_the_order_of_the_table(two, fold):
    page = le.write_report(two)
    assert page == two / PAGE
    report = content(page)
    assert [row["loop"] for row in report["rows"]] == ["B1", "A1"]
    first = report["rows"][0]
    assert first["file"] == "in/B1.pdb"
    assert first["sequence"] == "CUUCGG"
    assert first["rmsd_A"] == fold.candidates[0].rmsd_A
    assert first["expected_90_A"] == fold.candidates[0].expected_rmsd_A[2]
    assert first["candidates"] == len(fold.candidates)
    assert report["scenes"].keys() == {"2koc_A1", "2koc_B1"}


def test_it_says_where_all_is_from(two, fold):
    report = content(write_report(two))
    assert [len(one["sha256"]) for one in report["inputs"]] == [64, 64]
    assert report["options"]["persistence_length_A"] == fold.options.persistence_length_A
    assert report["versions"] == [le.__version__]
    assert le.__version__ in report["program"]


def test_it_needs_no_network(two):
    text = write_report(two).read_text(encoding="utf-8")
    packed = PLOTLY.search(text)[1]
    from plotly.offline import get_plotlyjs

    assert gzip.decompress(base64.b64decode(packed)).decode() == get_plotlyjs()
    own = text.replace(packed, "")
    assert not re.search(r"https?://|@import|url\(|src=|fetch\(|XMLHttpRequest", own)


def test_failures_stand_on_the_page_with_their_sentences(two):
    sentence = "in/c.pdb: no hairpin loop found; nothing to fold"
    (two / "failures.csv").write_text(f'file,failure\nin/c.pdb,"{sentence}"\n')
    assert content(write_report(two))["failures"] == [{"file": "in/c.pdb", "failure": sentence}]


@pytest.mark.parametrize(
    "name", ["</script><script>alert(1)</script>", "{{code}}", "\u2028", "]]>", "<!--"]
)
def test_no_name_of_a_file_or_a_loop_becomes_markup(tmp_path, make_run, name):
    out = make_run(tmp_path / "out", [name])
    (out / "failures.csv").write_text(f"file,failure\n{name},{name}: empty\n", encoding="utf-8")
    page = write_report(out)
    text = page.read_text(encoding="utf-8")
    plain = write_report(make_run(tmp_path / "plain", ["x"])).read_text(encoding="utf-8")
    for tag in ("<script", "</script", "<!--", "<html"):
        assert text.lower().count(tag) == plain.lower().count(tag)
    (row,) = content(page)["rows"]
    assert name in (row["loop"], row["loop"].encode().decode("unicode_escape"))


def test_without_a_table_every_folder_with_a_scene_counts(tmp_path, make_run):
    out = make_run(tmp_path / "out", ["B1", "A1"], table=False)
    (out / "notes").mkdir()
    assert [row["loop"] for row in content(write_report(out))["rows"]] == ["A1", "B1"]


def test_the_folder_of_one_loop_can_have_a_page_too(tmp_path, make_run):
    out = make_run(tmp_path / "out", ["A1"], table=False)
    report = content(write_report(out / "2koc_A1"))
    assert [(row["loop"], row["folder"]) for row in report["rows"]] == [("A1", "")]


def test_a_loop_that_was_written_without_a_scene_keeps_its_row(tmp_path, make_run, fold):
    out = make_run(tmp_path / "out", ["A1"], scenes=False)
    (row,) = content(write_report(out))["rows"]
    assert row["place"] is None
    assert row["rmsd_A"] == pytest.approx(fold.candidates[0].rmsd_A)
    assert row["loop"] == "A1"


def test_scenes_of_many_loops_stay_beside_the_page(tmp_path, make_run):
    out = make_run(tmp_path / "out", [f"A{k}" for k in range(21)])
    report = content(write_report(out))
    assert report["scenes"] == {}
    for row in report["rows"]:
        scene = read_scene(out / row["folder"] / report["scene"])
        assert scene["items"][row["place"]]["row"]["loop"] == row["loop"]


def test_ten_loops_of_ten_candidates_with_atoms_are_at_most_six_megabytes(
    tmp_path, make_run, atoms
):
    names = [f"A{k}" for k in range(10)]
    out = make_run(tmp_path / "out", names, atoms=atoms)
    for name in names:
        path = out / f"2koc_{name}" / "scene.js"
        scene = read_scene(path)
        (item,) = scene.pop("items")
        first = item["candidates"][0]
        item["candidates"] = [{**copy.deepcopy(first), "rank": k} for k in range(1, 11)]
        write_scene(path, [item], scene)
    page = write_report(out)
    assert len(content(page)["scenes"]) == 10
    assert page.stat().st_size < 6e6


def test_without_plotly_a_sentence_names_the_extra(two, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(MissingDependencyError, match=r"pip install loopelastica\[report\]"):
        write_report(two)


@pytest.mark.parametrize("there", [False, True])
def test_a_folder_without_results_is_named(tmp_path, there):
    folder = tmp_path / "empty"
    if there:
        folder.mkdir()
    with pytest.raises(LoopelasticaError, match=r"empty: .*nothing to report"):
        write_report(folder)


def test_a_page_of_somebody_else_is_left_alone(two):
    (two / PAGE).write_text("<!DOCTYPE html><p>mine</p>")
    with pytest.raises(FileExistsError, match="not written by this program"):
        write_report(two)
    assert renew_report(two, False) is None
    assert (two / PAGE).read_text() == "<!DOCTYPE html><p>mine</p>"


def test_a_run_without_a_page_leaves_none_of_an_earlier_one(two):
    assert renew_report(two, True) == two / PAGE
    assert renew_report(two, False) is None
    assert not (two / PAGE).exists()


def test_a_page_that_cannot_be_finished_leaves_the_former_one(two, monkeypatch):
    former = write_report(two).read_bytes()

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_text", full)
    with pytest.raises(OSError, match="No space"):
        write_report(two)
    assert (two / PAGE).read_bytes() == former
    assert [path.name for path in two.glob(".*html")] == []
