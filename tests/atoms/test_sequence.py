"""Hairpins as people write them."""

import pytest

from loopelastica.atoms.chemistry import Residue
from loopelastica.atoms.sequence import MAX_STEM, pair_of, read_sequence
from loopelastica.molecule.components import METHYLATED

UUCG = "GGCAC(UUCG)GUGCC"


@pytest.mark.parametrize(
    "text",
    [
        "ggcac(uucg)gugcc",
        " GGC AC (UU CG)\tGUG\nCC ",
        "5'-GGCAC(UUCG)GUGCC-3'",
        "5′ ggcac (uucg) gugcc 3′",
        "GGCACUUCGGUGCC (((((....)))))",
        "GGCACUUCGGUGCC(((((....)))))",
        "ggcac uucg gugcc ((((( .... )))))",
        ">2koc first\nGGCACUUCGGUGCC\n(((((....)))))",
        ">2koc\r\nGGCAC\r\nUUCGGUGCC\r\n(((((....))))) ( -5.20)\r\n",
        ">2koc\nGGCAC(UUCG)GUGCC",
    ],
)
def test_one_hairpin_is_written_in_many_ways(text):
    read = read_sequence(text)
    assert str(read) == UUCG
    assert not read.is_dna
    assert (read.pairs, len(read.loop), read.letters) == (5, 4, "GGCACUUCGGUGCC")


def test_the_dot_bracket_may_come_apart_from_the_sequence():
    assert str(read_sequence("GGCACUUCGGUGCC", "(((((....)))))")) == UUCG
    # a wider loop than its letters allow is what the user says
    assert str(read_sequence("GGCACUUCGGUGCC", "((((......))))")) == "GGCA(CUUCGG)UGCC"


def test_u_and_t_decide_the_kind():
    assert not read_sequence("GGC(AUA)GCC").is_dna
    assert read_sequence("GGC(ATA)GCC").is_dna
    assert [r.resname for r in read_sequence("GC(TTT)GC").strand_5] == ["DG", "DC"]
    assert [r.resname for r in read_sequence("GC(UUU)GC").strand_5] == ["G", "C"]


def test_both_kinds_at_once_are_named():
    with pytest.raises(ValueError, match=r"both U \(nucleotide 4\) and T \(nucleotide 6\).*\[DU\]"):
        read_sequence("GGC(UAT)GCC")


@pytest.mark.parametrize(
    ("text", "is_dna", "written"),
    [
        ("ggugc uucg guauc", False, "GGUGC(UUCG)GUAUC"),
        ("GGCAC-UUCG-GUGCC", False, "GGCAC(UUCG)GUGCC"),
        ("d(GCGC GAA GCGC)", True, "GCGC(GAA)GCGC"),
        ("r(GGC(AAA)GCC)", False, "GGC(AAA)GCC"),
        ("D( ggc(aaa)gcc )", True, "GGC(AAA)GCC"),
    ],
)
def test_three_words_and_kinds_in_front_are_read(text, is_dna, written):
    found = read_sequence(text)
    assert (str(found), found.is_dna) == (written, is_dna)


@pytest.mark.parametrize("text", ["GGC GAAA GC", "GG CC GG CC", "d(GCGC GAA GCGC)x"])
def test_other_words_are_no_hairpin(text):
    with pytest.raises(ValueError, match="`sequence`"):
        read_sequence(text)


@pytest.mark.parametrize("text", ["GGC(AAA)GCC"])
def test_a_kind_that_is_open_is_asked_for(text):
    with pytest.raises(ValueError, match=r"`rna` is needed: .* RNA, which has U, or DNA, whi"):
        read_sequence(text)


def test_a_kind_that_is_given_settles_what_is_open():
    assert read_sequence("GGC(AAA)GCC", rna=False).is_dna
    assert not read_sequence("GGC(AAA)GCC", rna=True).is_dna


@pytest.mark.parametrize(
    ("text", "rna", "said"),
    [
        ("GGC(UUU)GCC", False, r"U \(nucleotide 4\) is no base of DNA \(A, C, G, T\)"),
        ("GGC(TTT)GCC", True, r"T \(nucleotide 4\) is no base of RNA \(A, C, G, U\)"),
        ("GGC(AAT)GTC", True, r"T \(nucleotide 6\) is no base of RNA"),
        ("GGC(A[5MC]A)GCC", False, r"5MC \(nucleotide 5\) is no base of DNA"),
        ("GGC(A[DU]A)GCC", True, r"DU \(nucleotide 5\) is no base of RNA"),
    ],
)
def test_a_kind_that_contradicts_the_letters_is_refused(text, rna, said):
    with pytest.raises(ValueError, match=said):
        read_sequence(text, rna=rna)


@pytest.mark.parametrize(
    ("text", "structure", "said"),
    [
        ("", None, "`sequence` is ''; it must be two strands with the loop in brackets"),
        ("  \n ", None, "it must be two strands"),
        ("(((((....)))))", None, "it must be two strands"),
        ("GGCAC", None, "two strands with the loop in brackets"),
        ("GGCAC()GUGCC", "", "two strands|brackets"),
        (None, None, "`sequence` is None; it must be a text"),
        (7, None, "`sequence` is 7; it must be a text"),
        ("GGC(UUU)GCC", 7, "`structure` is 7; it must be a text"),
        ("G" * 20_000, None, "`sequence` has 20000 characters; a hairpin has at most 230"),
        ("GGC(UUU)GCC", "." * 20_000, "`structure` has 20000 characters"),
        ("GGC1(UUU)GCC", None, "'1', character 4 of .* is no nucleotide"),
        ("GG\u0421(UUU)GCC", None, "'\u0421', character 3 of .* is no nucleotide"),
        ("GGC\x00(UUU)GCC", None, r"character 4 of .* is no nucleotide"),
        ("../GGC(UUU)GCC", None, r"'\.', character 1 of .* is no nucleotide"),
        ("hairpins.fa", None, r"'\.', character 9 of .* is no nucleotide"),
        ("GGC-(UUU)-GCC", None, "'-', character 4"),
        ("GGN(UUU)NCC", None, r"N \(nucleotide 3\) is no known nucleotide"),
        ("GG[](UUU)CC", None, r"'\[', character 3"),
        ("GG[5MC(UUU)GCC", None, r"'\[', character 3"),
        ("GG[UUCG loop]CC", None, r"'\[', character 3"),
        ("GG[5M\nC](UUU)GCC", None, r"'\[', character 3"),
        ("(UUU)GCC", None, "no strand before the loop"),
        ("GGC(UUU)", None, "no strand behind the loop"),
        ("GGC(UUU)GCC(UUU)GCC", None, "it must be two strands"),
        ("GGC(UU(C)G)GCC", None, "it must be two strands"),
        ("GGC)UUU(GCC", None, "it must be two strands"),
        (">a\nGGC(UUU)GCC\n>b\nGGC(UUU)GCC", None, "holds several hairpins"),
        ("GGC(UU)GCC", None, "the loop has 2 nucleotides, not 3 to 30"),
        ("GGC()GUC", None, "the loop has 0 nucleotides"),
        ("GC(" + 31 * "U" + ")GC", None, "the loop has 31 nucleotides, not 3 to 30"),
        (101 * "G" + "(UUU)" + 101 * "C", None, "the stem has 101 pairs; at most 100"),
        ("GGC(UUU)GCC", "(((...)))", "its loop in brackets and a dot-bracket too"),
        ("GGCUUUGCC (((...)))", "(((...)))", "both hold a dot-bracket"),
        ("GGCUUUGCC", "(((...))", "has 8 characters for 9 nucleotides"),
        ("GGCUUUGCC", ".........", "it has no pair and so no stem"),
        ("GGCUUUGCC", "((....)))", "the bracket at C9 closes none"),
        ("GGCUUUGCC", "(((....))", "the bracket at G1 is not closed"),
        ("GGCUUUGCC", "(((.[.)))", r"'\[', character 5, is none of \( \) and \."),
        ("GGCUUUGCC", "(((-.-)))", "'-', character 4"),
    ],
)
def test_what_is_no_hairpin_is_refused_in_a_sentence(text, structure, said):
    with pytest.raises(ValueError, match=said) as refused:
        read_sequence(text, structure)
    assert len(str(refused.value)) < 400
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "structure", "said"),
    [
        ("GGC(UUCG)GC", None, "have 3 and 2 nucleotides; a stem needs equal ones .* G1 without"),
        ("GGAC(UUCG)GUCCA", None, "have 4 and 5 nucleotides; .* A13 without a partner"),
        # a bulge shows where the pairs get out of step
        ("GGACC(UUCG)GGCC", None, "have 5 and 4 nucleotides; .* A3 and C12 are the first that do"),
        ("AGGCUUUGCC", ".(((...)))", "A1 without a partner at the 5' end"),
        ("GGCUUUGCCAA", "(((...)))..", "A10 to A11 without a partner at the 3' end"),
        ("GGACUUUGCC", "((.(...)))", r"behind the pair G2·C9 it has a bulge, A3"),
        ("GGCUUUGAACC", "(((...)..))", r"behind the pair G2·C10 it has a bulge, A8 to A9"),
        ("GGACUUUGACC", "((.(...).))", "it has an internal loop, A3 and A9"),
        ("GGCUUUGCCGGCUUUGCC", "(((...)))(((...)))", "it has 2 loops, U4 to U6 and U13 to U15"),
        ("GGCUUUGCGCUUUGCC", "(((...)((...))))", "it has 2 loops"),
    ],
)
def test_a_stem_that_is_not_one_is_refused_with_the_place(text, structure, said):
    with pytest.raises(ValueError, match=said):
        read_sequence(text, structure)


@pytest.mark.parametrize("one", "ACGU")
@pytest.mark.parametrize("other", "ACGU")
def test_only_the_pairs_of_a_helix_make_a_stem(one, other):
    text = f"G{one}C(UUCG)G{other}C"
    if {one, other} in ({"A", "U"}, {"C", "G"}, {"G", "U"}):
        assert read_sequence(text).mismatches == ()
        return
    with pytest.raises(ValueError, match=f"{one}2·{other}9 do not pair, the stem is none"):
        read_sequence(text)
    assert read_sequence(text, mismatches=True).mismatches == (f"{one}2·{other}9",)


def test_thymine_pairs_as_uracil_does():
    t = Residue("T", True, "DT")
    assert [pair_of(t, Residue(x, True, f"D{x}")) for x in "ACGT"] == ["AU", None, "GU", None]


def test_modified_nucleotides_go_by_their_names():
    read = read_sequence("GG[5mc]A(UU[OMC]G)UGCC")
    assert [r.resname for r in read.residues][2:7] == ["5MC", "A", "U", "U", "OMC"]
    assert read.letters == "GGCAUUCGUGCC"
    assert str(read) == "GG[5MC]A(UU[OMC]G)UGCC"
    assert str(read_sequence(str(read))) == str(read)
    assert str(read_sequence("GG[5MC]AUUCGUGC[5MC] ((((....))))")) == "GG[5MC]A(UUCG)UGC[5MC]"
    assert read_sequence("GGC(A[DU]A)GCC").is_dna


@pytest.mark.parametrize("name", METHYLATED)
def test_every_modified_nucleotide_that_can_be_built_is_read(name):
    read = read_sequence(f"GGC(A[{name}]A)GCC")
    assert read.loop[1].resname == name
    assert read.loop[1].letter in "ACGUT"


def test_a_modified_nucleotide_that_cannot_be_built_is_refused_by_name():
    with pytest.raises(
        ValueError, match=r"H2U \(nucleotide 5\) is a nucleotide that cannot be bui"
    ):
        read_sequence("GGC(A[H2U]A)GCC")
    with pytest.raises(
        ValueError, match=r"XYZ \(nucleotide 5\) is no known .* in square brackets,"
    ):
        read_sequence("GGC(A[XYZ]A)GCC")


def test_two_methyl_groups_on_n2_leave_no_pair():
    with pytest.raises(ValueError, match="M2G2·C9 do not pair"):
        read_sequence("G[M2G]C(UUCG)GCC")


def test_the_longest_stem_is_read():
    assert read_sequence(MAX_STEM * "G" + "(UUU)" + MAX_STEM * "C").pairs == MAX_STEM
    assert read_sequence("G(UUU)C").pairs == 1
