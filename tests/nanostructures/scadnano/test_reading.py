"""Designs of scadnano as systems; what is read is compared with what scadnano says of itself."""

import sys

import helix_designs as designs
import numpy as np
import pytest

from loopelastica.errors import MissingDependencyError, StructureError
from loopelastica.nanostructures.oxdna.energies import bonds
from loopelastica.nanostructures.scadnano.reading import read_design
from loopelastica.nanostructures.singles import single_strands

sc = designs.sc

COMPLEMENT = {"A": "T", "C": "G", "G": "C", "T": "A"}


@pytest.fixture
def read(tmp_path):
    """Reads a design that scadnano has written."""
    return lambda design, **options: read_design(designs.write(design, tmp_path), **options)


def origami(**options):
    from scadnano.origami_rectangle import create

    return create(num_helices=6, num_cols=12, **options)


def test_partners_are_the_base_pairs_of_scadnano(read):
    design = origami(assign_seq=False)
    found = read(design)
    paired = np.flatnonzero(found.system.pair >= 0)
    places = sorted(zip(found.helix[paired].tolist(), found.offset[paired].tolist(), strict=True))
    expected = design.base_pairs(allow_mismatches=True)
    assert places[::2] == places[1::2]
    assert places[::2] == sorted((h, at) for h, offsets in expected.items() for at in offsets)


def test_partners_are_mutual_and_of_opposite_directions(read):
    system = read(designs.turned_groups(150)).system
    np.testing.assert_array_equal(system.pair[system.pair], np.arange(len(system)))
    np.testing.assert_allclose((system.a3 * system.a3[system.pair]).sum(1), -1)


def test_nucleotides_go_strand_by_strand_from_5_to_3(read):
    design = origami()
    system = read(design).system
    assert "".join(system.base) == "".join(strand.dna_sequence for strand in design.strands)
    ends = np.cumsum([strand.dna_length() for strand in design.strands])
    expected = np.arange(1, len(system) + 1)
    expected[ends - 1] = -1
    np.testing.assert_array_equal(system.n3, expected)
    inner = np.flatnonzero(system.n3 >= 0)
    np.testing.assert_array_equal(system.n5[system.n3[inner]], inner)
    assert (system.n5 >= 0).sum() == len(inner)


@pytest.mark.parametrize("length", [3, 4, 10, 60])
def test_a_loopout_on_its_helix_is_a_hairpin_without_places(read, length):
    found = read(designs.hairpin(length))
    (single,) = single_strands(found.system)
    assert (single.kind, len(single), found.why(single)) == ("hairpin", length, "loopout")
    assert not found.system.placed[single.nucleotides].any()
    assert found.system.placed.sum() == 24


@pytest.mark.parametrize("apart", [1, 2, 3])
@pytest.mark.parametrize("length", [2, 30])
def test_a_loopout_between_helices_is_a_linker(read, apart, length):
    found = read(designs.linker(length, apart))
    (single,) = single_strands(found.system)
    assert (single.kind, len(single)) == ("linker", length)
    assert found.helix[[single.before, single.after]].tolist() == [0, apart]
    assert found.offset[[single.before, single.after]].tolist() == [19, 19]


def test_extensions_are_tails(read):
    design = designs.row_of(1)
    design.draw_strand(0, 0).extension_5p(4).move(20).extension_3p(7)
    design.draw_strand(0, 20).move(-20)
    found = read(design)
    kinds = [(s.kind, len(s), found.why(s)) for s in single_strands(found.system)]
    assert kinds == [("tail 5'", 4, "extension"), ("tail 3'", 7, "extension")]


def test_domains_without_a_partner_and_the_loopout_between_them_are_one_single_strand(read):
    design = designs.row_of(2)
    design.draw_strand(0, 0).move(16).loopout(1, 4).move(-16)
    design.draw_strand(0, 10).move(-10)
    design.draw_strand(1, 0).move(8)
    found = read(design)
    (single,) = single_strands(found.system)
    assert found.why(single) == "unpaired domain, loopout, unpaired domain"
    assert len(single) == 6 + 4 + 8
    assert found.offset[[single.before, single.after]].tolist() == [9, 7]
    assert not found.system.placed[single.nucleotides].any()


def test_a_design_without_a_pair_has_no_places_but_those_of_the_drawing(read):
    design = designs.row_of(1)
    design.draw_strand(0, 0).move(20)
    found = read(design)
    assert not found.system.placed.any()
    assert [single.kind for single in single_strands(found.system)] == ["free strand"]
    whole = read(designs.duplex(20)).system
    np.testing.assert_allclose(found.system.centre, whole.centre[:20])


def test_insertions_and_deletions_of_both_strands_are_pairs_of_a_longer_or_shorter_helix(read):
    design = designs.row_of(1)
    for start, length in ((0, 30), (30, -30)):
        design.draw_strand(0, start).move(length).with_insertions((5, 2)).with_deletions(20)
    system = read(design).system
    assert (system.pair >= 0).all()
    np.testing.assert_array_equal(system.pair, np.arange(62)[::-1])
    lengths = bonds(system).length
    np.testing.assert_allclose(lengths, lengths[0])


@pytest.mark.parametrize("forward", [True, False])
@pytest.mark.parametrize("inserted", [1, 4])
def test_an_insertion_of_one_strand_is_a_bulge_of_a_helix_that_stays(read, forward, inserted):
    design = designs.row_of(1)
    one, other = (0, 30), (30, -30)
    start, length = one if forward else other
    design.draw_strand(0, start).move(length).with_insertions((9, inserted))
    start, length = other if forward else one
    design.draw_strand(0, start).move(length)
    found = read(design)
    system = found.system
    (single,) = single_strands(system)
    assert (single.kind, len(single)) == ("linker", inserted)
    assert system.strand[single.nucleotides].tolist() == [0] * inserted
    assert sorted(found.offset[[single.before, single.after]].tolist()) == [8, 9]
    (axis,) = found.axes
    whole = read(designs.duplex(30)).axes[0]
    np.testing.assert_allclose(axis.end, whole.end)
    assert np.isfinite(bonds(system).backbone).all()


@pytest.mark.parametrize("forward", [True, False])
def test_a_deletion_of_one_strand_leaves_the_base_across_without_a_partner(read, forward):
    design = designs.row_of(1)
    one, other = (0, 30), (30, -30)
    start, length = one if forward else other
    design.draw_strand(0, start).move(length).with_deletions([9])
    start, length = other if forward else one
    design.draw_strand(0, start).move(length)
    found = read(design)
    (single,) = single_strands(found.system)
    assert found.system.label[single.nucleotides[0]] == "helix 0, offset 9"
    assert found.system.strand[single.nucleotides].tolist() == [1]
    lengths = bonds(found.system).length
    np.testing.assert_allclose(lengths, lengths[0])


def test_an_insertion_where_only_one_strand_is_moves_what_comes_after_on_both(read):
    design = designs.row_of(1)
    design.draw_strand(0, 0).move(30).with_insertions((3, 2))
    design.draw_strand(0, 30).move(-20)
    found = read(design)
    assert (found.system.pair >= 0).sum() == 40
    np.testing.assert_allclose(found.axes[0].end, read(designs.duplex(32)).axes[0].end)


def test_a_circular_strand_has_no_ends(read):
    design = designs.row_of(2)
    design.draw_strand(0, 0).move(20).cross(1).move(-20).as_circular()
    design.draw_strand(0, 20).move(-20)
    found = read(design)
    system = found.system
    np.testing.assert_array_equal(system.n3[:40], np.roll(np.arange(40), -1))
    np.testing.assert_array_equal(system.n5[:40], np.roll(np.arange(40), 1))
    assert system.n3[59] == system.n5[40] == -1
    assert "circular strands (1, first ST0[0]1[0])" in found.notes[0]


def test_sequences_that_are_given_are_kept(read):
    design = origami()
    found = read(design)
    assert not any("no base" in note for note in found.notes)


def test_what_has_no_sequence_gets_one_that_pairs(read):
    design = designs.hairpin(5)
    system = read(design).system
    assert system.base[12:17].tolist() == ["T"] * 5
    paired = np.flatnonzero(system.pair >= 0)
    partners = system.base[system.pair[paired]]
    assert [COMPLEMENT[base] for base in system.base[paired]] == partners.tolist()
    assert set(system.base[:12].tolist()) == set("ACGT")
    again, other = read(design), read(design, seed=5)
    assert again.system.base.tolist() == system.base.tolist()
    assert other.system.base.tolist() != system.base.tolist()
    assert "29 of 29 nucleotides have no base" in other.notes[0]
    assert "seed 5" in other.notes[0]


def test_a_base_across_from_one_that_is_given_is_its_complement(read):
    design = designs.duplex(8)
    design.strands[1].set_dna_sequence("ACGT??GG")
    found = read(design)
    given = found.system.base[8:]
    assert "".join(given[[0, 1, 2, 3, 6, 7]]) == "ACGTGG"
    partners = [COMPLEMENT[base] for base in given[::-1]]
    assert found.system.base[:8].tolist() == partners
    assert "10 of 16 nucleotides have no base" in found.notes[0]


def test_sequences_in_lower_case_and_with_blanks_are_read(tmp_path):
    def change(content):
        content["strands"][0]["sequence"] = "acgt ac\ngt"

    path = designs.changed(designs.duplex(8), tmp_path, change)
    assert "".join(read_design(path).system.base[:8]) == "ACGTACGT"


def test_partners_that_do_not_fit_are_counted_in_a_note(read):
    design = designs.duplex(8)
    design.strands[0].set_dna_sequence("AAAAAAAA")
    design.strands[1].set_dna_sequence("TTTTTCCC")
    assert "3 pairs are not complementary, so oxDNA will not hold them" in read(design).notes


@pytest.mark.parametrize(("letter", "said"), [("U", "RNA"), ("X", "no base of DNA")])
def test_bases_that_are_none_of_dna_are_refused(tmp_path, letter, said):
    def change(content):
        content["strands"][1].update(sequence="AC" + letter + "TACGT", name="odd")

    with pytest.raises(StructureError, match=f"odd has '{letter}'.*{said}"):
        read_design(designs.changed(designs.duplex(8), tmp_path, change))


def test_names_labels_and_colours_are_those_of_scadnano(read):
    design = designs.hairpin(2)
    design.draw_strand(0, 20).move(20).with_name("second").with_color(sc.Color(1, 2, 255))
    design.draw_strand(0, 40).move(-20)
    found = read(design)
    system = found.system
    exported = [strand.default_export_name() for strand in design.strands]
    assert system.strand_name == (exported[0], "second", exported[2])
    drawn = [strand.color for strand in design.strands]
    assert system.colour == tuple(f"#{c.r:02x}{c.g:02x}{c.b:02x}" for c in drawn)
    assert system.colour[1] == "#0102ff"
    assert system.label[11:15] == (
        "helix 0, offset 11",
        "loopout nucleotide 1 of 2",
        "loopout nucleotide 2 of 2",
        "helix 0, offset 11",
    )


def test_strands_without_a_colour_get_those_that_scadnano_would_give(tmp_path):
    design = designs.hairpins(15)
    design.strands[3].set_scaffold()

    def change(content):
        for strand in content["strands"]:
            strand.pop("color")

    colours = read_design(designs.changed(design, tmp_path, change)).system.colour
    cycle = sc.ColorCycler()
    expected = [next(cycle) for _ in range(14)]
    expected.insert(3, sc.default_scaffold_color)
    assert colours == tuple(f"#{c.r:02x}{c.g:02x}{c.b:02x}" for c in expected)


def test_crossovers_that_are_too_long_are_named(read):
    design = designs.row_of(2)
    design.draw_strand(0, 0).move(20).cross(1).move(-20)
    design.draw_strand(0, 20).move(-20)
    design.draw_strand(1, 0).move(20)
    notes = read(design).notes
    assert any("1 bond is outside of oxDNA's window" in note for note in notes)
    assert any("from helix 0, offset 19 to helix 1, offset 19" in note for note in notes)


def test_an_origami_with_its_own_twist_and_narrow_gaps_has_all_bonds_in_the_window(read):
    design = origami(assign_seq=False)
    design.geometry = sc.Geometry(bases_per_turn=32 / 3, inter_helix_gap=0.1)
    design.relax_helix_rolls()
    energy = bonds(read(design).system).backbone
    assert len(energy) > 2000
    assert np.isfinite(energy).all()


def test_helices_in_one_place_are_named(read):
    design = sc.Design(
        helices=[sc.Helix(max_offset=20, grid_position=(0, 0)) for _ in range(2)], grid=sc.square
    )
    for i in range(2):
        design.draw_strand(i, 0).move(20)
        design.draw_strand(i, 20).move(-20)
    notes = read(design).notes
    said = "40 pairs of nucleotides are nearer to each other than 0.4, first from helix 0, offset"
    assert any(said in note for note in notes)


def test_a_thousand_strands_are_read_as_each_alone(read):
    system = read(designs.hairpins(1000)).system
    singles = single_strands(system)
    assert [len(s) for s in singles] == [6] * 1000
    assert {s.kind for s in singles} == {"hairpin"}
    alone = read(designs.hairpins(1)).system
    np.testing.assert_allclose(system.centre[:26], alone.centre, atol=1e-9)
    np.testing.assert_array_equal(system.pair[26:52], np.where(alone.pair < 0, -1, alone.pair + 26))


def test_modifications_are_ignored_with_a_note(read):
    design = designs.duplex()
    biotin = sc.Modification5Prime(display_text="B", vendor_code="/5Biosg/")
    design.strands[0].set_modification_5p(biotin)
    assert "strands with modifications (1, first ST0[0]0[31])" in read(design).notes[0]


def test_helices_without_a_grid_stand_where_their_positions_say(read):
    place = sc.Position3D(3, 4, 5)
    design = sc.Design(helices=[sc.Helix(max_offset=20, position=place)])
    design.draw_strand(0, 0).move(20)
    design.draw_strand(0, 20).move(-20)
    found = read(design)
    np.testing.assert_allclose(found.axes[0].begin, np.array([3, 4, 5]) / 0.8518)
    assert "they stand where their positions say" in found.notes[0]


def test_without_the_package_a_sentence_names_the_extra(tmp_path, monkeypatch):
    path = designs.write(designs.duplex(), tmp_path)
    monkeypatch.setitem(sys.modules, "scadnano", None)
    with pytest.raises(MissingDependencyError, match=r"pip install loopelastica\[origami\]"):
        read_design(path)


@pytest.mark.parametrize("path", ["", None, 3])
def test_a_path_that_is_none_is_an_argument_error(path):
    with pytest.raises(ValueError, match="`path`"):
        read_design(path)


def test_reading_prints_nothing(tmp_path, capsys):
    design = designs.hairpins(2)
    for strand in design.strands:
        strand.set_name("the same")

    def change(content):
        marked = {"location": "5'", "vendor_code": "other", "display_text": "B"}
        content["modifications_5p_in_design"] = {"mark": marked}

    read_design(designs.changed(design, tmp_path, change))
    assert capsys.readouterr().out == ""
