"""What counts as a simple loop."""

import dataclasses
from pathlib import Path

import pytest

import loopelastica as le
from loopelastica.studies.evaluation.loops import _about


@pytest.mark.parametrize(
    ("name", "simple"), [("A.7-8", False), ("A.6-8", True), ("A.3-11", True), ("A.3-12", False)]
)
def test_simple_loops_have_three_to_nine_nucleotides(koc, name, simple):
    (loop,) = le.fold(koc, loop=name, all_models=False, irregular=True, length_per_nucleotide_A=9.0)
    alone = dataclasses.replace(loop, hairpin=dataclasses.replace(loop.hairpin, contacts=()))
    assert _about(Path("some.pdb"), alone, 1)["simple"] == simple
    touched = dataclasses.replace(
        loop, hairpin=dataclasses.replace(loop.hairpin, contacts=(("A.U6", "A.A4"),))
    )
    assert not _about(Path("some.pdb"), touched, 1)["simple"]
