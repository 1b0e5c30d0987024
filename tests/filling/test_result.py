"""What a filling says of itself, and where it is written."""

import gapped
import gemmi
import pytest

import loopelastica as le
from loopelastica.errors import LoopelasticaError

pytest.importorskip("rdkit")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Chain A lacks two nucleotides; of those that B lacks nobody knows the bases."""
    atoms = [*gapped.chain({6, 7}), "TER", *gapped.chain({9}, name="B", moved=40.0)]
    return gapped.pdb(tmp_path_factory.mktemp("result") / "ab.pdb", atoms, head=gapped.seqres())


@pytest.fixture(scope="module")
def filling(file):
    return le.fill(file)


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    path = gapped.gapped(tmp_path_factory.mktemp("several") / "c.pdb", {4, 5, 6, 7, 8, 9, 10})
    return le.fill(path, candidates=3)


def test_names_are_public(filling):
    assert isinstance(filling, le.Filling)
    assert all(isinstance(strand, le.FilledStrand) for strand in filling.strands)


def test_what_it_shows_of_itself_is_short(filling):
    assert repr(filling) == "<Filling of ab.pdb: 1 strands filled, 1 refused>"
    filled, refused = filling.strands
    assert repr(filled).startswith("<FilledStrand A.6-7 UU: sound, ")
    assert repr(refused).startswith("<FilledStrand B.9 N: refused, B.9: the numbers say")
    assert repr(filled.candidates[0]) == "<FilledCandidate 1: rod in its surroundings, sound>"
    assert "<td>A.6-7</td>" in filling._repr_html_()


def test_a_refused_strand_has_no_figures(filling):
    refused = filling.strands[1]
    assert refused.candidates == ()
    assert refused.sound is None
    assert refused.expected_rmsd_A is None
    assert refused.distance_A is None
    assert list(filling.failures) == [refused.reason]


def test_a_name_of_the_format_is_a_file(filling, tmp_path):
    for name in ("a.pdb", "b.ent", "deep/er/c.PDB"):
        path = filling.write(tmp_path / name)
        assert path.read_text() == filling.text()
    assert {p.name for p in tmp_path.iterdir()} == {"a.pdb", "b.ent", "deep"}


def test_any_other_name_is_a_folder(filling, tmp_path):
    path = filling.write(str(tmp_path / "some.result"))
    assert {p.name for p in path.iterdir()} == {"filled.pdb", "fill.json"}


def test_a_name_of_the_other_format_is_refused(filling, tmp_path):
    with pytest.raises(ValueError, match=r"`path` .* is PDB.*name it \*\.pdb"):
        filling.write(tmp_path / "a.cif")
    of_mmcif = le.fill(gapped.gapped_cif(tmp_path / "x.cif", {7}))
    with pytest.raises(ValueError, match=r"`path` .* is mmCIF.*name it \*\.cif"):
        of_mmcif.write(tmp_path / "a.pdb")
    assert gemmi.read_structure(str(of_mmcif.write(tmp_path / "a.mmcif")))
    assert {p.name for p in tmp_path.iterdir()} == {"x.cif", "a.mmcif"}


def test_a_compressed_name_is_refused(filling, tmp_path):
    with pytest.raises(ValueError, match=r"`path` .* compressed"):
        filling.write(tmp_path / "a.pdb.gz")
    assert list(tmp_path.iterdir()) == []


def test_the_input_is_never_written_over(filling, file, tmp_path):
    before = file.read_text()
    (tmp_path / "link.pdb").symlink_to(file)
    for path in (file, tmp_path / "link.pdb"):
        with pytest.raises(ValueError, match="the file that was filled"):
            filling.write(path)
    assert file.read_text() == before


def test_what_cannot_be_written_is_one_sentence(filling, tmp_path):
    (tmp_path / "file").write_text("mine")
    for name in ("file", "file/a.pdb", "file/folder"):
        with pytest.raises((OSError, LoopelasticaError)) as caught:
            filling.write(tmp_path / name)
        assert str(tmp_path / "file") in str(caught.value)
    assert (tmp_path / "file").read_text() == "mine"


def test_a_folder_holds_a_file_per_candidate(several, tmp_path):
    (strand,) = several.strands
    n = len(strand.candidates)
    assert 1 < n <= 3
    assert [one.rank for one in strand.candidates] == list(range(1, n + 1))
    folder = several.write(tmp_path / "out")
    names = ["filled.pdb", *(f"filled_{k}.pdb" for k in range(2, n + 1))]
    assert {p.name for p in folder.iterdir()} == {*names, "fill.json"}
    texts = [(folder / name).read_text() for name in names]
    assert len(set(texts)) == n
    for k, name in enumerate(names, start=1):
        assert several.text(k) == texts[k - 1]
        if strand.candidates[k - 1].sound:
            gapped.check_chain(gapped.read(folder / name))


def test_the_candidates_are_different_shapes(several):
    traces = [candidate.trace for candidate in several.strands[0].candidates]
    for k, one in enumerate(traces):
        for other in traces[:k]:
            assert abs(one - other).max() > 1.0


def test_a_sound_candidate_comes_before_one_that_is_not(several):
    sound = [candidate.sound for candidate in several.strands[0].candidates]
    assert sound == sorted(sound, reverse=True)


@pytest.mark.parametrize("rank", [0, -1, 1.5, "1"])
def test_a_rank_counts_from_one(filling, rank):
    with pytest.raises(ValueError, match="`rank`"):
        filling.text(rank)


def test_notes_have_what_is_odd_of_strands_too(tmp_path):
    path = gapped.gapped(tmp_path / "a.pdb", {1, 6, 7, (8, "N3"), (11, "N3")})
    notes = list(le.fill(path).notes)
    assert any("A.C8 beside the gap lacks N3" in note for note in notes)
    assert "missing atoms were added to A.C8, A.U11" in notes
    assert any("missing at the 5' end" in note for note in notes)
    assert list(le.fill(gapped.gapped(tmp_path / "b.pdb", ())).notes) == [
        "no internal gap; nothing to fill"
    ]


def test_sentences_name_the_model_where_there_are_several(tmp_path):
    models = [gapped.chain({6, 7}), gapped.chain({6, 7}, model=2)]
    filling = le.fill(gapped.pdb(tmp_path / "a.pdb", *models))
    first, second = filling.failures
    assert first.startswith("model 1: A.6-7: ")
    assert second.startswith("model 2: A.6-7: ")
