import numpy as np

from loopelastica._files import data_path
from loopelastica.studies.strands.selection import Cut, _strands, _type, cuts, distinct


def partners(brackets):
    partner, open_ = np.full(len(brackets), -1), []
    for k, sign in enumerate(brackets):
        if sign == "(":
            open_.append(k)
        elif sign == ")":
            partner[k] = open_.pop()
            partner[partner[k]] = k
    return partner


def types(brackets, broken=()):
    joined = np.ones(len(brackets) - 1, dtype=bool)
    joined[list(broken)] = False
    found = _strands(partners(brackets), joined)
    return {(a, b): what for a, b, what in found if what not in ("helix", "unpaired")}


def test_the_loop_that_a_strand_belongs_to_says_its_type():
    assert types("((...))") == {(2, 4): "hairpin"}
    assert types("((.((...))))")[2, 2] == "bulge"
    assert types("((.((...))..))") == {(2, 2): "internal", (5, 7): "hairpin", (10, 11): "internal"}
    assert types("((.((...))((...)).))")[2, 2] == "junction"
    assert types("(((...))).(((...)))")[9, 9] == "joint"


def test_a_broken_chain_gives_no_strand_across_the_break():
    assert (2, 4) not in types("((...))", broken=[3])
    assert types("((.((...))..))", broken=[11]) == {(2, 2): "joint", (5, 7): "hairpin"}


def test_strands_inside_runs_leave_a_neighbour_on_both_sides():
    joined = np.ones(13, dtype=bool)
    inside = [
        (a, b) for a, b, what in _strands(partners("((..........))"), joined) if what == "unpaired"
    ]
    assert inside
    assert all(a >= 3 and b <= 10 for a, b in inside)
    assert {b - a + 1 for a, b in inside} == set(range(1, 9))


def test_a_pseudoknot_ends_the_walk():
    partner = partners("((..((..))..))")
    partner[[2, 7]] = [7, 2]
    assert _type(partner, np.ones(13, dtype=bool), 10, 11) in ("joint", "internal", "junction")


def test_cuts_of_a_real_hairpin():
    found = cuts(data_path("hairpins/2koc.pdb"))
    assert ("A.6-9", "hairpin", 4) in [(c.name, c.type, c.n) for c in found]
    assert {c.kind for c in found} == {"RNA"}
    assert all(len(c.context) >= c.n for c in found)


def test_an_unreadable_file_has_none(tmp_path):
    (tmp_path / "x.pdb").write_text("nothing\n")
    assert cuts(tmp_path / "x.pdb") == []


def test_relatives_count_once(tmp_path):
    one = Cut(tmp_path / "a", "A.1", "RNA", "bulge", 1, "GGAGG")
    copy = Cut(tmp_path / "b", "B.1", "RNA", "bulge", 1, "GGAGG")
    other = Cut(tmp_path / "b", "B.2", "RNA", "bulge", 1, "GGCGG")
    assert distinct([one, copy, other]) == [one, other]
