import pytest

from loopelastica.studies.nanostructures.designs import FAMILIES, LARGE, drawn

ALL = (*FAMILIES, *LARGE)


@pytest.mark.parametrize("number", [0, 3])
@pytest.mark.parametrize("key", [one.key for one in ALL])
def test_a_design_has_about_as_many_single_strands_as_asked_for(key, number, laid):
    _, found = laid(key, number, 10)
    assert 6 <= len(found.strands) <= 16


@pytest.mark.parametrize(
    ("key", "kinds", "shortest", "longest"),
    [
        ("hairpins", {"hairpin"}, 3, 60),
        ("linkers", {"linker"}, 2, 60),
        ("unpaired", {"linker"}, 1, 36),
        ("spacers", {"linker"}, 2, 6),
        ("tails", {"tail 5'", "tail 3'"}, 1, 40),
        ("many-short", {"linker"}, 5, 5),
    ],
)
def test_a_family_is_what_its_name_says(key, kinds, shortest, longest, laid):
    _, found = laid(key, 1, 12)
    assert {str(one.kind) for one in found.strands} == kinds
    lengths = [len(one) for one in found.strands]
    assert shortest <= min(lengths)
    assert max(lengths) <= longest
    if key == "hairpins":
        assert (min(lengths), max(lengths)) == (shortest, longest)


def test_a_design_can_be_drawn_again_alone_and_another_seed_draws_another(family):
    pytest.importorskip("scadnano")
    crowds = family("crowds")
    one, same, other = (drawn(crowds, 2, seed).to_json() for seed in (5, 5, 6))
    assert one == same != other
