"""What a structure holds."""

import pytest

from loopelastica.molecule.nucleotides import read_structure
from loopelastica.report.listing import modified


@pytest.mark.parametrize(("renamed", "listed"), [(1, 1), (6, 6), (7, 0), (14, 0)])
def test_where_half_of_the_names_are_odd_they_are_another_programs(
    tmp_path, koc_lines, renamed, listed
):
    path = tmp_path / "named.pdb"
    lines = [s[:17] + "XYZ" + s[20:] if int(s[22:26]) <= renamed else s for s in koc_lines]
    path.write_text("\n".join([*lines, "END", ""]))
    found = modified(read_structure(path))
    assert len(found) == listed
    assert not listed or found["A.XYZ1"] == "G"
