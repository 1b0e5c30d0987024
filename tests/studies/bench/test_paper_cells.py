"""The settings of the paper's studies."""

from loopelastica.studies.bench.paper_cells import cells_of


def test_cells_are_the_papers():
    cells = cells_of((3, 4, 5))
    assert len(cells) == 12 + 1 + 10
    counts = {(cell.l, cell.delta): cell.paper_rods for cell in cells}
    assert counts[2, 2] == 3622
    assert counts[2, 1] == 2154
    assert counts[2, 0.25] == 50946
    # "overall 797 138 inversions" (Fig. 4)
    assert sum(cell.paper_rods for cell in cells if cell.figure == 4 and cell.symmetry) == 797138
