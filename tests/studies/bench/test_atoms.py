import csv
import json

from loopelastica._files import data_path
from loopelastica.studies.bench.atoms import run


def test_the_bench_measures_a_folder_and_sums_up(tmp_path):
    folder = tmp_path / "in"
    folder.mkdir()
    for name in ("a.pdb", "b.pdb"):
        text = data_path("hairpins/2koc.pdb").read_text().split("ENDMDL")[0]
        (folder / name).write_text(text + "ENDMDL\nEND\n")
    (folder / "c.pdb").write_text("nothing\n")
    text = run(folder, tmp_path / "out", sample=2)
    summary = json.loads((tmp_path / "out" / "atoms.json").read_text())
    assert summary["built"] == 1
    assert summary["bonds within 0.05 Å"] >= 0.99
    assert summary["not sound"] == []
    assert "median of the difference" in text
    with (tmp_path / "out" / "atoms.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["file"] for row in rows] == ["a.pdb", "c.pdb"]
    assert "this is not a PDB structure" in rows[1]["failure"]
