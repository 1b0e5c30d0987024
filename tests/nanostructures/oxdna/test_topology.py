import re

import numpy as np
import pytest
import strands

from loopelastica.errors import StructureError
from loopelastica.nanostructures.oxdna.topology import parse_topology, topology_text, written_order

# the example of the program's documentation: GCGTTG, listed from 3' to 5' there
DOCUMENTED = "6 1\n1 G -1 1\n1 C 0 2\n1 G 1 3\n1 T 2 4\n1 T 3 5\n1 G 4 -1\n"
NEW = "9 2 5->3\nACGT type=DNA\nGCA(13)(-10) type=DNA circular=true\n"


def system_of(topology):
    """A system that a topology says, at no place."""
    n = len(topology.base)
    nowhere = np.zeros((n, 3))
    made = strands.system_of([("A" * n, nowhere, nowhere, nowhere)])
    fields = {name: getattr(topology, name) for name in ("base", "strand", "n3", "n5", "rna")}
    return strands.replace(
        made,
        **fields,
        strand_name=topology.strand_name,
        colour=("",) * len(topology.strand_name),
    )


def test_the_documented_example_is_read():
    top = parse_topology("a.top", DOCUMENTED)
    assert top.form == "old"
    assert "".join(top.base) == "GCGTTG"
    np.testing.assert_array_equal(top.n3, [-1, 0, 1, 2, 3, 4])
    np.testing.assert_array_equal(top.n5, [1, 2, 3, 4, 5, -1])
    assert top.strand_name == ("strand 1",)


def test_the_new_form_runs_from_5_to_3_and_knows_rings_and_special_bases():
    top = parse_topology("a.top", NEW)
    assert top.form == "new"
    assert top.base.tolist() == ["A", "C", "G", "T", "G", "C", "A", "13", "-10"]
    np.testing.assert_array_equal(top.n3, [1, 2, 3, -1, 5, 6, 7, 8, 4])
    np.testing.assert_array_equal(top.n5, [-1, 0, 1, 2, 8, 4, 5, 6, 7])
    np.testing.assert_array_equal(top.strand, [0] * 4 + [1] * 5)


def test_names_and_types_of_strands_are_taken_from_the_new_form():
    lines = "ACG id=scaffold\nAC type=RNA circular=no\nA id=7\n"
    top = parse_topology("a.top", f"6 3 5->3\n{lines}")
    assert top.strand_name == ("scaffold", "strand 2", "strand 7")
    assert top.rna.tolist() == [False, True, False]


def test_strands_with_uracil_and_no_thymine_are_rna():
    top = parse_topology("a.top", "4 3\n1 U -1 1\n1 A 0 -1\n2 T -1 -1\n3 A -1 -1\n")
    assert top.rna.tolist() == [True, False, False]


def test_small_letters_comments_and_empty_lines_are_read_as_the_program_does():
    top = parse_topology("a.top", "2 1\n# made by hand\n\n1 a -1 1\n1 g 0 -1\n\n")
    assert top.base.tolist() == ["A", "G"]


def test_any_negative_neighbour_is_none():
    top = parse_topology("a.top", "2 1\n1 A -7 1\n1 G 0 -2\n")
    assert (top.n3[0], top.n5[1]) == (-1, -1)


def test_numbers_of_letters_in_parentheses_are_letters():
    top = parse_topology("a.top", "4 1 5->3\n(0)(1)(2)(3)\n")
    assert "".join(top.base) == "AGCT"


@pytest.mark.parametrize("text", [DOCUMENTED, NEW.replace("DNA\nG", "RNA\nG")])
def test_a_topology_is_written_as_it_was(text):
    top = parse_topology("a.top", text)
    assert topology_text(system_of(top), top.form) == text


def test_both_forms_say_the_same():
    old = parse_topology("a.top", DOCUMENTED + "")
    system = system_of(old)
    new = parse_topology("a.top", topology_text(system, "new"))
    # bases from 5' to 3': the documented strand the other way round
    assert "".join(new.base) == "GTTGCG"
    order = written_order(system, "new")
    np.testing.assert_array_equal(old.base[order], new.base)
    back = np.argsort(order)
    for mine, other in ((old.n3, new.n3), (old.n5, new.n5)):
        np.testing.assert_array_equal(np.where(mine >= 0, back[mine], -1)[order], other)


def test_a_ring_survives_both_forms():
    system = system_of(parse_topology("a.top", NEW))
    old = topology_text(system, "old")
    again = system_of(parse_topology("a.top", old))
    assert topology_text(again, "new") == NEW
    assert old.splitlines()[5:7] == ["2 G 8 5", "2 -10 4 6"]


def test_the_old_form_lists_strands_from_3_to_5_as_its_documentation_wants():
    text = topology_text(system_of(parse_topology("a.top", "9 2 5->3\nGTTGCG\nACG\n")), "old")
    one, other = DOCUMENTED.splitlines()[1:], ["2 G -1 7", "2 C 6 8", "2 A 7 -1"]
    assert text.splitlines() == ["9 2", *one, *other]


def test_a_strand_in_pieces_keeps_its_order_in_the_old_form():
    text = "3 1\n1 A 1 -1\n1 C -1 0\n1 G -1 -1\n"
    assert topology_text(system_of(parse_topology("a.top", text)), "old") == text


def test_a_strand_in_pieces_has_no_new_form():
    system = system_of(parse_topology("a.top", "2 1\n1 A -1 -1\n1 G -1 -1\n"))
    with pytest.raises(StructureError, match=r"strand 1 is in pieces.*old form"):
        topology_text(system, "new")


REFUSED = {
    "nothing": ("", "no oxDNA topology"),
    "a configuration": ("t = 0\nb = 1 1 1\nE = 0 0 0\n", "no oxDNA topology"),
    "a third word": ("2 1 3->5\nAC\n", "no oxDNA topology"),
    "no nucleotides": ("0 0\n", "0 nucleotides"),
    "proteins": ("30 3 20 10 1\n", "proteins"),
    "too few": ("3 1\n1 A -1 1\n1 C 0 -1\n", "says 3 nucleotides, but 2 follow"),
    "too many": ("1 1\n1 A -1 1\n1 C 0 -1\n", "says 1 nucleotides, but 2 follow"),
    "huge": ("999999999 1\n1 A -1 -1\n", "but 1 follow"),
    "strands": ("2 2\n1 A -1 1\n1 C 0 -1\n", "says 2 strands, but 1 follow"),
    "columns": ("1 1\n1 A -1\n", "line 2"),
    "no number": ("1 1\n1 A x -1\n", "line 2: 'x'"),
    "long number": ("1 1\n1 A 99999999999999999999999 -1\n", "line 2"),
    "peptide": ("1 1\n-1 A -1 -1\n", "line 2: strand -1.*proteins"),
    "amino acid": ("2 1\n1 A -1 1\n1 K 0 -1\n", "line 3: the base 'K'"),
    "digit": ("1 1\n1 3 -1 -1\n", "line 2: the base '3'"),
    "outside": ("2 1\n1 A -1 1\n1 C 0 7\n", "nucleotide 1 has 7 as its 5' neighbour"),
    "itself": ("1 1\n1 A 0 0\n", "nucleotide 0 has as its 3' neighbour itself"),
    "not mutual": (
        "3 1\n1 A -1 1\n1 C 0 2\n1 G 0 -1\n",
        "nucleotide 2 has as its 3' neighbour nucleotide 0, whose 5' neighbour is another",
    ),
    "two strands": ("2 2\n1 A -1 1\n2 C 0 -1\n", "of another strand"),
    "new too few": ("5 1 5->3\nACGT\n", "says 5 nucleotides, but 4 follow"),
    "new strands": ("4 2 5->3\nACGT\n", "says 2 strands, but 1 follow"),
    "new peptide": ("4 1 5->3\nMKVL type=peptide\n", "line 2: the type is 'peptide'"),
    "new base": ("4 1 5->3\nACXT\n", "line 2: the base 'X'"),
    "open": ("4 1 5->3\nAC(12\n", r"line 2: the base '\('"),
    "seven": ("1 1 5->3\n(7)\n", "the base '7'"),
    "words": ("4 1 5->3\nACGT circular\n", "key=value"),
    "neither": ("4 1 5->3\nACGT circular=maybe\n", "circular is 'maybe'"),
    "ring of one": ("1 1 5->3\nA circular=true\n", "itself"),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_a_damaged_topology_is_refused_in_one_sentence(fault):
    text, says = REFUSED[fault]
    with pytest.raises(StructureError, match=says) as refusal:
        parse_topology("a.top", text)
    sentence = str(refusal.value)
    assert sentence.startswith("a.top")
    assert "\n" not in sentence
    assert not re.search(r"nan|None|Traceback", sentence)
