"""Files that are no designs, and those of older scadnano."""

import gzip
import json

import helix_designs as designs
import pytest

from loopelastica.errors import StructureError
from loopelastica.nanostructures.scadnano.file import load
from loopelastica.nanostructures.scadnano.reading import read_design

sc = designs.sc


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "the file is empty"),
        (b" \n ", "the file is empty"),
        (b"{", "this is no JSON, as a scadnano design is"),
        (b"\x89PNG\r\n\x1a\n\x00\xff", "this is no text in UTF-8"),
        (b"[" * 100_000, "this is no JSON, as a scadnano design is"),
        (b'{"version": NaN}', "NaN is no number of JSON"),
        (b"[1, 2]", "the JSON has no helices and strands"),
        (b'{"vstrands": []}', "this is a design of cadnano"),
        (b'{"version": "0.21.1"}', "the design has no helices"),
        (b'{"helices": [], "strands": []}', "the design has no helices"),
        (b'{"helices": [{"max_offset": 9}], "grid": "square"}', "the design has no strands"),
    ],
)
def test_what_is_no_design_is_refused_in_a_sentence(tmp_path, content, said):
    path = tmp_path / "no.sc"
    path.write_bytes(content)
    with pytest.raises(StructureError) as caught:
        load(path)
    assert said in str(caught.value)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(StructureError, match=r"absent\.sc: there is no such file"):
        load(tmp_path / "absent.sc")


def test_a_compressed_design_is_read(tmp_path):
    path = tmp_path / "design.sc.gz"
    path.write_bytes(gzip.compress(designs.duplex().to_json().encode()))
    assert len(read_design(path).system) == 64


def test_names_of_fields_that_older_versions_had_are_read(tmp_path):
    design = {
        "version": "0.2.0",
        "grid": "square",
        "helices": [{"grid_position": [0, 0, 0]}],
        "strands": [
            {
                "color": 16711680,
                "dna_sequence": "ACGTACGT",
                "substrands": [{"helix": 0, "right": True, "start": 0, "end": 8}],
            },
            {"substrands": [{"helix": 0, "right": False, "start": 0, "end": 8}]},
        ],
        "geometry": {"z_step": 0.34},
    }
    path = tmp_path / "old.sc"
    path.write_text(json.dumps(design))
    system = read_design(path).system
    assert "".join(system.base) == "ACGTACGT" * 2
    assert system.colour[0] == "#ff0000"
    assert system.centre[1, 2] == pytest.approx(0.34 / 0.8518)


@pytest.mark.parametrize("numbers", [(0, 1), (7, 3)])
def test_a_design_whose_helices_are_shown_in_another_order_is_read(tmp_path, numbers):
    first, second = numbers
    helices = [sc.Helix(idx=i, max_offset=32, grid_position=(0, i)) for i in numbers]
    design = sc.Design(helices=helices, grid=sc.square, helices_view_order=[second, first])
    design.draw_strand(first, 0).move(12).loopout(second, 20).move(-12)
    design.draw_strand(second, 0).move(12)
    system = read_design(designs.write(design, tmp_path)).system
    assert system.label[32:] == tuple(
        f"helix {second}, offset {k}" for k in (*range(11, -1, -1), *range(12))
    )


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.update(grid="round"), "'round' is not a valid Grid"),
        (lambda d: d["helices"][0].update(grid_position=[0]), r"helices[0]: scadnano cannot read"),
        (lambda d: d["strands"][0].update(sequence="ACG"), "strands[0]: scadnano cannot read it"),
        (lambda d: d["strands"][0].update(sequence=5), "strands[0]: scadnano cannot read it"),
        (lambda d: d["strands"][0].update(color="red"), "strands[0]: scadnano cannot read it"),
        (lambda d: d.update(groups={}), 'cannot specify both "grid" and "groups"'),
        (
            lambda d: d["helices"][0].update(grid_position=["a", 0]),
            "the grid position of helix 0 has 'a'",
        ),
        (lambda d: d["helices"][0].update(roll="up"), "of helix 0 has 'up'"),
    ],
)
def test_what_the_package_refuses_is_one_sentence_that_says_where(tmp_path, change, said):
    path = designs.changed(designs.duplex(), tmp_path, change)
    with pytest.raises(StructureError) as caught:
        read_design(path)
    message = str(caught.value)
    assert said in message
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    assert len(message) < 500
