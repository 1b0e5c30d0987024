"""Public names: each with an example that is run, each call's keywords by their names."""

import inspect
import re
import types

import pytest

import loopelastica as le
from loopelastica._files import data_path

HAIRPIN = data_path("hairpins/2koc.pdb")
NAMES = [name for name in le.__all__ if name != "__version__"]
_ORDER = ("Parameters", "Attributes", "Returns", "Yields", "Raises", "Examples")


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_has_an_example(name):
    examples = inspect.getdoc(getattr(le, name)).split("Examples\n--------\n")
    assert len(examples) == 2
    assert ">>> " in examples[1]


@pytest.mark.parametrize("name", NAMES)
def test_sections_come_in_the_order_of_numpydoc_and_each_once(name):
    found = re.findall(r"^(\w+)\n-+$", inspect.getdoc(getattr(le, name)), re.M)
    assert found == [section for section in _ORDER if section in found]


def _calls():
    """Public functions, and public methods of public classes."""
    for name in NAMES:
        public = getattr(le, name)
        if not inspect.isclass(public):
            yield f"{public.__module__}.{public.__qualname__}"
        elif public.__module__.startswith("loopelastica"):
            for method, value in vars(public).items():
                if not method.startswith("_") and isinstance(
                    value, types.FunctionType | classmethod | staticmethod
                ):
                    yield f"{public.__module__}.{public.__qualname__}.{method}"


@pytest.mark.parametrize("call", [*_calls()])
def test_parameters_and_results_are_explained_as_numpydoc_wants_them(call):
    """PR: parameters, their order and types; RT01, YD01: what comes back; GL07: sections."""
    validate = pytest.importorskip("numpydoc.validate").validate
    wanted = {"PR01", "PR02", "PR03", "PR04", "RT01", "YD01", "GL06", "GL07", "GL08", "SS01"}
    assert [error for error in validate(call)["errors"] if error[0] in wanted] == []


@pytest.mark.parametrize(
    ("call", "near"),
    [
        (lambda: le.fold(HAIRPIN, tapper=0.1), "fold takes no `tapper`; .* `taper`"),
        (lambda: le.fold(HAIRPIN, candidates=3), "fold takes no `candidates`; .* `max_candidates`"),
        (lambda: le.scan(HAIRPIN, extend_5=1), "scan takes no `extend_5`; .* `extend_5_max`"),
        (lambda: le.fill(HAIRPIN, strand="A.7"), "fill takes no `strand`; .* `strands`"),
        (lambda: le.build("GGC(GAA)GCC", hydrogen=True), "build takes no .* `hydrogens`"),
        (lambda: le.find_hairpins(HAIRPIN, pairs="A.1-A.9"), "find_hairpins takes no .* `pair`"),
        (lambda: le.build_atoms(HAIRPIN, None, try_=1), "build_atoms takes no `try_`"),
        (lambda: le.fold(HAIRPIN, zzz=1), "fold takes no `zzz`; it takes `free_spin`, "),
        (lambda: le.fold(HAIRPIN, True), "fold takes one argument beside its options, `structure`"),
        (lambda: le.fill(), "fill takes one argument beside its options, `structure`"),
    ],
)
def test_a_keyword_that_is_unknown_gets_a_sentence_with_the_nearest(call, near):
    with pytest.raises(TypeError, match=near):
        call()


@pytest.mark.parametrize(
    "call",
    [
        lambda: le.fold(structure="absent.pdb"),
        lambda: le.scan(structure="absent.pdb"),
        lambda: le.fill(structure="absent.pdb"),
        lambda: le.nanostructure(path="absent.top"),
    ],
)
def test_what_is_read_may_be_given_by_name(call):
    with pytest.raises(le.StructureError, match="absent"):
        call()
