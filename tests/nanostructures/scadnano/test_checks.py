"""Designs that are wrong in one place."""

import helix_designs as designs
import pytest

from loopelastica.errors import StructureError
from loopelastica.nanostructures.scadnano.reading import read_design

sc = designs.sc


def part(design, number, **fields):
    design["strands"][0]["domains"][number].update(fields)


def loopouts(design, *places):
    for place in places:
        design["strands"][0]["domains"].insert(place, {"loopout": 4})


def twice(design):
    design["strands"].append(design["strands"][0])


def no_grid(design):
    design["grid"] = "none"
    del design["helices"][0]["grid_position"]


def in_group(design):
    del design["grid"]
    design["groups"] = {"left": {"position": {"x": 0, "y": 0, "z": 0}, "grid": "none"}}
    design["helices"][0]["group"] = "left"
    del design["helices"][0]["grid_position"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.update(version="99.0.0"), "the version is '99.0.0', unknown to"),
        (lambda d: d.update(version="newest"), "the version is 'newest', which is none"),
        (lambda d: d.update(version="9" * 9999), "which is none of scadnano"),
        (lambda d: d.update(version=0.21), "the version is 0.21, which is none"),
        (lambda d: d.update(helices=[]), "no helices, so there is nothing to place"),
        (lambda d: d.update(strands=[]), "no strands, so there is nothing to place"),
        (lambda d: d.update(strands=None), "no strands, so there is nothing to place"),
        (lambda d: d.update(strands=[3]), "strands[0] is 3; it must be an object"),
        (no_grid, "the grid is none and helix 0 has no position"),
        (in_group, "the grid is none and helix 0 has no position"),
        (lambda d: d["strands"][0].update(domains=[]), "strands[0] (pin) has no domains"),
        (
            lambda d: d["strands"][0].update(domains=[{"extension_num_bases": 5}]),
            "strands[0] (pin) has no domain on a helix",
        ),
        (lambda d: loopouts(d, 0), "strands[0] (pin) has a loopout at its 5' end"),
        (lambda d: loopouts(d, 3), "strands[0] (pin) has a loopout at its 3' end"),
        (lambda d: loopouts(d, 1), "two loopouts in a row, domains[1] and domains[2]"),
        (lambda d: part(d, 1, loopout=0), "domains[1]: loopout is 0; it must be a whole number"),
        (lambda d: part(d, 1, loopout=True), "domains[1]: loopout is True; it must be"),
        (lambda d: part(d, 1, loopout=10**8), "more than the 2,000,000 that are read"),
        (lambda d: part(d, 0, start=12), "begins at offset 12 and ends before offset 12"),
        (lambda d: part(d, 0, start="0"), "domains[0]: start is '0'; it must be a whole number"),
        (lambda d: part(d, 0, forward=1), "domains[0]: forward is 1; it must be true or false"),
        (lambda d: part(d, 0, helix=7), "0 to 11 of helix 7, which the design does not have"),
        (lambda d: part(d, 0, end=80), "offsets 0 to 79 of helix 0, which has offsets 0 to 63"),
        (lambda d: part(d, 0, start=-1), "offsets -1 to 11 of helix 0, which has offsets 0"),
        (lambda d: part(d, 2, forward=True), "overlap on helix 0 at offset 0, both forward"),
        (twice, "strands[0] (pin) and strands[1] (pin) overlap on helix 0 at offset 0"),
        (lambda d: part(d, 0, deletions=[12]), "deletion at offset 12 is outside of the domain"),
        (lambda d: part(d, 0, deletions=[3, 3]), "two insertions or deletions at one offset"),
        (
            lambda d: part(d, 0, deletions=[3], insertions=[[3, 1]]),
            "two insertions or deletions at one offset",
        ),
        (lambda d: part(d, 0, insertions=[[3, 0]]), "they must be pairs of an offset and"),
        (lambda d: part(d, 0, insertions=3), "they must be pairs of an offset and"),
        (lambda d: part(d, 0, deletions=["3"]), "they must be offsets"),
        (lambda d: d["helices"][0].update(min_offset=0.5), "they must be whole numbers"),
        (lambda d: d["helices"][0].update(max_offset=10**9), "must be whole numbers below 10⁹"),
        (lambda d: part(d, 0, end=2**70), "it must be a whole number below 10⁹"),
        (lambda d: part(d, 1, loopout=10**12), "1 or more and below 10⁹"),
        (lambda d: d["strands"][0].update(circular="yes"), "circular is 'yes'; it must be true or"),
        (
            lambda d: d["strands"][0].update(
                circular=True, domains=[{"helix": 0, "forward": True, "start": 0, "end": 2}]
            ),
            "2 nucleotides, too few for a strand that is circular",
        ),
        (
            lambda d: d["strands"][0].update(
                domains=[
                    {"helix": 0, "forward": True, "start": 0, "end": 2, "deletions": [0, 1]},
                ]
            ),
            "0 nucleotides, too few for a strand",
        ),
    ],
)
def test_a_fault_is_one_sentence_that_names_file_and_place(tmp_path, change, said):
    design = designs.hairpin()
    design.strands[0].set_name("pin")
    path = designs.changed(design, tmp_path, change)
    with pytest.raises(StructureError) as caught:
        read_design(path)
    message = str(caught.value)
    assert said in message
    assert message.startswith(f"{path}: ")
    assert "\n" not in message


@pytest.mark.parametrize("version", [None, "0.1.0", "0.19.4", "0.21.99", "0.21.1-dev"])
def test_versions_up_to_the_installed_one_are_read(tmp_path, version):
    def change(design):
        if version is None:
            del design["version"]
        else:
            design["version"] = version

    path = designs.changed(designs.hairpin(), tmp_path, change)
    assert len(read_design(path).system) == 29


def test_a_ring_that_is_listed_from_a_loopout_on_is_told_how_to_be_listed(tmp_path):
    def change(design):
        loopouts(design, 3)
        design["strands"][0]["circular"] = True

    with pytest.raises(StructureError, match="list the parts of this circular strand from a dom"):
        read_design(designs.changed(designs.hairpin(), tmp_path, change))


def test_a_loopout_that_also_names_a_helix_is_a_loopout(tmp_path):
    path = designs.changed(designs.hairpin(), tmp_path, lambda d: part(d, 1, helix=0))
    assert read_design(path).drawn[12:17].tolist() == ["loopout"] * 5
