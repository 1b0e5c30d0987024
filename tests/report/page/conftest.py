"""Folders of runs, with what a page shows of them."""

import csv
import dataclasses

import pytest

from loopelastica._files import data_path
from loopelastica.batch.folds import COLUMNS, loop_rows
from loopelastica.molecule.setting import Settings
from loopelastica.report.folder import write_fold

HAIRPIN = data_path("hairpins/2koc.pdb")


@pytest.fixture(scope="session")
def make_run(koc, fold):
    """Write a folder of results: some loops, each under a name of its own."""
    shared = Settings(koc)

    def make(out, names, scenes=True, atoms=None, table=True):
        rows = []
        for name in names:
            hairpin = dataclasses.replace(fold.hairpin, name=name)
            loop = dataclasses.replace(fold, hairpin=hairpin)
            folder = out / f"2koc_{name}".replace("/", "_")
            write_fold(
                folder, HAIRPIN, loop, koc, plot=False, atoms=atoms,
                settings=shared, report=scenes,
            )  # fmt: skip
            rows += [{**row, "folder": folder.name} for row in loop_rows(f"in/{name}.pdb", loop)]
        if table:
            with (out / "summary.csv").open("w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore")
                writer.writeheader()
                writer.writerows(rows)
        return out

    return make
