import csv
import json

import pytest

from loopelastica._files import data_path
from loopelastica.studies.strands.deletion import run


@pytest.mark.slow
def test_strands_of_a_folder_are_taken_out_and_filled_again(tmp_path):
    folder = tmp_path / "files"
    folder.mkdir()
    first, end, _ = data_path("hairpins/2koc.pdb").read_text().partition("ENDMDL")
    (folder / "2koc.pdb").write_text(f"{first}{end}\nEND\n")
    text = run([folder], tmp_path / "out", sample=2)
    with (tmp_path / "out" / "strands.csv").open() as file:
        rows = list(csv.DictReader(file))
    hairpin = next(row for row in rows if row["strand"] == "A.6-9")
    assert hairpin["type"] == "hairpin"
    assert hairpin["sound"] == "True"
    for name in ("chord", "cubic", "free_rod", "line", "atoms"):
        assert 0.0 < float(hairpin[f"rmsd_{name}_A"]) < 8.0
    # what is taken out is not looked at: nothing comes back exactly
    assert all(float(row["rmsd_atoms_A"]) > 1e-3 for row in rows)
    assert "RNA hairpin | 3-4 | 1 |" in text
    content = json.loads((tmp_path / "out" / "calibration.json").read_text())
    assert set(content) == {"table", "covered"}
