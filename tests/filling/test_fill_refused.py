"""What cannot be filled is a sentence, and the file stays as it is."""

import gzip

import gapped
import pytest

import loopelastica as le

pytest.importorskip("rdkit")

PROTEIN = [
    "ATOM      1  N   ALA A   1      11.104   6.134  -6.504  1.00  0.00           N",
    "ATOM      2  CA  ALA A   1      11.639   6.071  -5.147  1.00  0.00           C",
    "ATOM      3  C   ALA A   1      10.656   5.387  -4.203  1.00  0.00           C",
]
FORTY = gapped.SEQUENCE[:5] + "U" * 40 + gapped.SEQUENCE[9:]


def far(atoms):
    """The second half 40 Å away."""
    return [
        line if int(line[22:26]) < 6 else f"{line[:30]}{float(line[30:38]) + 40:8.3f}{line[38:]}"
        for line in atoms
    ]


def named(name, k=5):
    """SEQRES with another name for one nucleotide."""
    lines = gapped.seqres()
    start = 19 + 4 * k
    return [lines[0][:start] + f"{name:>3}" + lines[0][start + 3 :], *lines[1:]]


REFUSED = {
    "no sequence": ([], {}, ["A.6-7", "2 nt", "has no sequence", "A.6-7=NN"]),
    "other letters": (gapped.seqres("A" * 14), {}, ["A.6-7", "contradicts the file"]),
    "another flank": (gapped.seqres("GGCAGUUCGGUGCC"), {}, ["A.6-7", "contradicts the file"]),
    "unknown base": (named("N"), {}, ["A.6-7", "the base of A.N6 is not known"]),
    "unknown name": (named("XYZ"), {}, ["A.6-7", "the base of A.XYZ6 is not known"]),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_gap_whose_sequence_is_not_clear_is_refused_in_a_sentence(tmp_path, case):
    head, options, fragments = REFUSED[case]
    path = gapped.pdb(tmp_path / "a.pdb", gapped.chain({6, 7}), head=head)
    filling = le.fill(path, **options)
    (strand,) = filling.strands
    assert (strand.status, strand.candidates, strand.sound) == ("refused", (), None)
    for fragment in fragments:
        assert fragment in strand.reason
    assert "\n" not in strand.reason
    assert filling.text() == path.read_text()


@pytest.mark.xfail(
    strict=True, reason="a record without the missing nucleotides is believed, a wide gap or not"
)
def test_a_record_that_is_too_short_for_the_numbers_and_the_distance_is_refused(tmp_path):
    head = gapped.seqres("GGCACCGGUGCC")
    (strand,) = le.fill(gapped.pdb(tmp_path / "a.pdb", gapped.chain({6, 7}), head=head)).strands
    assert strand.status == "refused"


@pytest.mark.xfail(
    strict=True, reason="where the numbers do not jump, a contradiction is a remark and no refusal"
)
def test_a_broken_bond_in_a_chain_that_contradicts_its_record_is_refused(tmp_path):
    places = [(k if k < 6 else k - 2, "") for k in range(1, 15)]
    atoms = gapped.chain({6, 7}, places=places)
    head = gapped.seqres("GGCAGUUCGGUGCC")
    filling = le.fill(gapped.pdb(tmp_path / "a.pdb", atoms, head=head))
    assert [strand.status for strand in filling.strands] == ["refused"]


def test_a_gap_that_cannot_be_spanned_is_refused_with_both_distances(tmp_path):
    path = gapped.pdb(tmp_path / "a.pdb", far(gapped.chain({6, 7})), head=gapped.seqres())
    (strand,) = le.fill(path).strands
    assert strand.status == "refused"
    assert "2 nt cannot span 49.8 Å" in strand.reason
    assert "reach 18 Å" in strand.reason


def test_a_gap_of_forty_is_refused(tmp_path):
    places = [(k if k < 6 else k + 36, "") for k in range(1, 15)]
    atoms = gapped.chain({6, 7, 8, 9}, places=places)
    (strand,) = le.fill(gapped.pdb(tmp_path / "a.pdb", atoms, head=gapped.seqres(FORTY))).strands
    assert (strand.status, strand.nucleotides) == ("refused", 40)
    assert "40 nt are missing" in strand.reason


def test_missing_ends_are_named_and_left(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {1, 2, 13, 14})
    filling = le.fill(path)
    assert filling.strands == ()
    assert filling.text() == path.read_text()
    first, second = filling.remarks
    assert "A.1-2 (GG)" in first
    assert "5' end" in first
    assert "A.13-14 (CC)" in second
    assert "3' end" in second


def test_two_chains_of_one_name_are_refused(tmp_path):
    atoms = [*gapped.chain({6, 7}), "TER", *gapped.chain({6, 7}, moved=40.0)]
    path = gapped.pdb(tmp_path / "a.pdb", atoms, head=gapped.seqres())
    filling = le.fill(path)
    assert filling.filled == ()
    assert all("two chains are named A" in strand.reason for strand in filling.strands)
    assert filling.text() == path.read_text()


def test_so_are_they_without_a_ter_between_them(tmp_path):
    atoms = [*gapped.chain({6, 7}), *gapped.chain({6, 7}, moved=40.0)]
    path = gapped.pdb(tmp_path / "a.pdb", atoms, head=gapped.seqres())
    assert le.fill(path).filled == ()


def test_one_refused_gap_does_not_stop_the_others(tmp_path):
    atoms = [*far(gapped.chain({6, 7})), "TER", *gapped.chain({9}, name="B", moved=90.0)]
    head = [*gapped.seqres(), *gapped.seqres(name="B")]
    filling = le.fill(gapped.pdb(tmp_path / "a.pdb", atoms, head=head))
    assert sorted(strand.status for strand in filling.strands) == ["filled", "refused"]
    gapped.check_chain(gapped.read(filling.write(tmp_path / "filled.pdb")), name="B")


def test_a_structure_without_nucleotides_is_one_sentence(tmp_path):
    path = gapped.pdb(tmp_path / "a.pdb", PROTEIN)
    with pytest.raises(le.StructureError, match=r"a\.pdb: no nucleotide found among 1 residues"):
        le.fill(path)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.pdb", b""),
        ("empty.cif", b""),
        ("blank.cif", b"data_x\n"),
        ("noise.pdb", bytes(range(256)) * 10),
        ("cut.pdb.gz", gzip.compress(gapped.TEXT.encode())[:3000]),
        ("some.xyz", b"1\n\nC 0 0 0\n"),
    ],
)
def test_what_is_no_structure_is_one_sentence(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(le.StructureError, match=name) as caught:
        le.fill(tmp_path / name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("strands", "fragments"),
    [
        ("A.6-7=UUU", ["A.6-7=UUU", "2 nt", "3"]),
        ("B.6-7=UU", ["B.6-7=UU", "no chain B"]),
        ("A.6=U", ["A.6=U", "A.7"]),
        ("A.6-7", ["A.6-7", "the file does not say"]),
        ("A.600-601=UU", ["A.600-601=UU", "A.G1 to A.C14"]),
        (["A.6-7=UU", "B.1=U"], ["B.1=U", "no chain B"]),
    ],
)
def test_a_strand_that_contradicts_the_file_is_a_sentence_that_names_it(
    tmp_path, strands, fragments
):
    path = gapped.pdb(tmp_path / "a.pdb", gapped.chain({6, 7}))
    with pytest.raises(le.StructureError) as caught:
        le.fill(path, strands=strands)
    sentence = str(caught.value)
    assert sentence.startswith(f"{path}: `strands` ")
    assert sentence.count(str(path)) == 1
    for fragment in fragments:
        assert fragment in sentence


def test_a_strand_at_the_end_of_a_chain_is_refused(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {1, 2})
    with pytest.raises(le.StructureError, match="nothing stands on its 5' side"):
        le.fill(path, strands="A.1-2=GG")
