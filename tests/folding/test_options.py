"""One object of options behind fold, scan and the analysis: checked, frozen, JSON-ready."""

import dataclasses
import inspect
import json
import pickle

import numpy as np
import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica.folding.options import FoldOptions, ScanOptions

HAIRPIN = data_path("hairpins/2koc.pdb")
NAN, INF = float("nan"), float("inf")
SHARED = {
    "free_spin": ("yes", 1, None),
    "torsion_ratio": (0, -1.0, NAN, INF, "1", None, True),
    "length_per_nucleotide_A": (0, -6, NAN, "6"),
    "persistence_length_A": (-10, 0, NAN, INF, "10", [10]),
    "irregular": ("no", 2),
    "pair": (5, None, [5], {"A.1-A.9": 1}),
    "dot_bracket": (5, ["(...)"]),
    "loop": (5, [None], b"A.6-9"),
}
FOLD = {
    "stem_extend_5": (-1, 0.5, NAN, INF, "1", True),
    "stem_extend_3": (-1, 1.5, "one"),
    "taper": (-0.1, 0.31, NAN, "0.1"),
    "energy_max": (0, -5, NAN, INF, "30"),
    "max_candidates": (0, 0.5, -1, 1.5, NAN, "3", None, True),
    "all_models": ("all", 0),
    "shapes": ("rods", "", None, 1, ["rod"]),
    "rank": ("Energy", "", None, 1),
    "like": ("", " ", 5, b"1zih.pdb", "a\0b"),
    "library": ("", 5, ["loops.lib"]),
    "exclude_relatives": ("no", 1, None),
    "surroundings": ("no", 1, None),
}
SCAN = {
    "extend_5_max": (-1, 0.5, NAN, "1", None),
    "extend_3_max": (-1, 0.5, NAN, "1"),
    "tapers": ((), 0.1, "0.1", [0.9], [-0.1], [NAN], [0.1, "0.2"], None),
}


def cases(table):
    return [(name, value) for name, values in table.items() for value in values]


@pytest.mark.parametrize(("name", "value"), cases(SHARED | FOLD))
def test_fold_refuses_what_is_out_of_range_by_name(name, value):
    with pytest.raises(ValueError, match=f"^`{name}` is "):
        le.fold("never read.pdb", **{name: value})


@pytest.mark.parametrize(("name", "value"), cases(SHARED | SCAN))
def test_scan_refuses_what_is_out_of_range_by_name(name, value):
    with pytest.raises(ValueError, match=f"^`{name}` is "):
        le.scan("never read.pdb", **{name: value})


@pytest.mark.parametrize(("name", "value"), cases({"min_loop": (0, "3", NAN, 2.5)}))
def test_find_hairpins_refuses_what_is_out_of_range_by_name(name, value):
    with pytest.raises(ValueError, match=f"^`{name}` is "):
        le.find_hairpins(HAIRPIN, **{name: value})
    with pytest.raises(ValueError, match="`max_loop` is 4"):
        le.find_hairpins(HAIRPIN, min_loop=5, max_loop=4)


def test_unknown_options_are_refused():
    for function in (le.fold, le.scan):
        with pytest.raises(TypeError, match="tapper"):
            function(HAIRPIN, tapper=0.1)
    with pytest.raises(TypeError, match="max_candidates"):
        le.scan(HAIRPIN, max_candidates=3)


def test_options_are_frozen_json_ready_and_come_back():
    options = FoldOptions(taper=np.float32(0.25), stem_extend_5=np.int64(1), pair="A.6-A.9")
    assert (type(options.taper), type(options.stem_extend_5)) == (float, int)
    with pytest.raises(dataclasses.FrozenInstanceError):
        options.taper = 0.1
    for made in (options, ScanOptions(tapers=np.array([0.0, 0.1]), loop=["A.6-9"])):
        content = json.loads(json.dumps(made.to_dict()))
        assert type(made)(**content) == made
        assert pickle.loads(pickle.dumps(made)) == made


def test_the_keywords_are_seen_in_signature_and_docstring():
    for function, options in ((le.fold, FoldOptions), (le.scan, ScanOptions)):
        names = [item.name for item in dataclasses.fields(options)]
        parameters = inspect.signature(function).parameters
        assert list(parameters)[1:] == names
        assert all(f"{name}" in function.__doc__ for name in names)
        assert "{options}" not in function.__doc__
        assert all(p.kind is p.KEYWORD_ONLY for n, p in parameters.items() if n != "structure")
    names = set(inspect.signature(le.LoopElastica).parameters)
    assert {"atoms", "taper", "pair", "max_candidates", "persistence_length_A"} <= names
    assert le.LoopElastica.__doc__.count("    max_candidates : ") == 1
    for name in ("all_models", "max_size_MB", "max_atoms"):
        assert name not in names
        assert name in le.fold.__doc__
        assert f"    {name} : " not in le.LoopElastica.__doc__


def test_the_bounds_themselves_are_allowed():
    assert [FoldOptions(taper=taper).taper for taper in (0, 0.3)] == [0.0, 0.3]
    assert ScanOptions(tapers=[0.0, 0.3]).tapers == (0.0, 0.3)
    assert FoldOptions(max_candidates=1, stem_extend_5=0).max_candidates == 1


@pytest.mark.parametrize("options", [FoldOptions, ScanOptions])
@pytest.mark.parametrize(
    ("name", "value"),
    [("pair", "A.5"), ("loop", ["A.6-9", "nonsense"]), ("dot_bracket", "(("), ("dot_bracket", 5)],
)
def test_pairs_loops_and_brackets_are_understood_when_the_options_are_made(options, name, value):
    with pytest.raises(ValueError, match=f"`{name}`"):
        options(**{name: value})


def test_a_template_is_a_file_and_perhaps_a_pair(tmp_path):
    assert FoldOptions(like="a.pdb:A.4-A.9").like == "a.pdb:A.4-A.9"
    assert FoldOptions(like=tmp_path / "a.pdb").like == str(tmp_path / "a.pdb")
    with pytest.raises(ValueError, match="`like`"):
        FoldOptions(like=3)
    with pytest.raises(ValueError, match="`like` goes without `shapes`"):
        FoldOptions(like="a.pdb", shapes="rod")
