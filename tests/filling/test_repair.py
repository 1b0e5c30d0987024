"""What is broken is mended by the shortest stretch, and nothing else moves."""

import json

import damage
import gemmi
import numpy as np
import pytest

import loopelastica as le

pytest.importorskip("rdkit")
TRUTH = damage.first_model()


def repaired(tmp_path, lines, **options):
    path = tmp_path / "broken.pdb"
    path.write_text("\n".join(lines) + "\n")
    filling = le.fill(path, repair=True, **options)
    return filling, filling.text().splitlines()


def untouched(before, after, but):
    """Whether the lines of all residues but some are the same to the digit, in the same order."""

    def others(lines):
        return [x[12:66] for x in damage.rows(lines) if damage.key(x)[0] not in but]

    return others(before) == others(after)


def test_a_sound_structure_stays_as_it_is(tmp_path):
    filling, _ = repaired(tmp_path, TRUTH)
    assert filling.repaired == () == filling.unrepaired
    assert not list(filling.failures)


def test_without_repair_no_atom_moves(tmp_path):
    path = tmp_path / "broken.pdb"
    path.write_text("\n".join(damage.shifted(TRUTH, 6, 7, [0.0, 3.0, 0.0])) + "\n")
    filling = le.fill(path)
    assert filling.repaired == ()
    assert not filling.repairs


def test_a_broken_bond_is_mended_by_one_nucleotide(tmp_path):
    lines = damage.broken(TRUTH, 7, np.array([1.0, 1.0, 1.0]))
    filling, text = repaired(tmp_path, lines)
    assert len(filling.repairs) == 1
    assert filling.repairs[0].labels == ("A.U7",)
    assert "A.U6–A.U7: O3'–P" in filling.repaired[0]
    assert "rebuilt A.U7" in filling.repaired[0]
    assert not damage.wrong(text)
    assert untouched(lines, text, {7})
    assert damage.rmsd(text, TRUTH, {7}) < 0.6


@pytest.mark.parametrize("number", range(2, 14))
def test_a_mirrored_sugar_is_turned_over_and_its_base_stays(tmp_path, number):
    lines = damage.mirrored(TRUTH, number)
    filling, text = repaired(tmp_path, lines)
    assert "wrong hand at C1'" in filling.repaired[0]
    assert not damage.wrong(text)
    assert untouched(lines, text, {number})
    now, then = damage.heavy(text), damage.heavy(lines)
    base = [k for k in then if k[0] == number and "'" not in k[1] and "P" not in k[1]]
    assert base
    assert all((now[k] == then[k]).all() for k in base)


@pytest.mark.parametrize("number", [1, 14])
def test_a_sugar_at_an_end_of_the_chain_is_mended_too(tmp_path, number):
    lines = damage.mirrored(TRUTH, number)
    _, text = repaired(tmp_path, lines)
    assert not damage.wrong(text)
    assert untouched(lines, text, {number})


@pytest.mark.parametrize("stretch", [(6, 6), (5, 7), (8, 12)])
@pytest.mark.parametrize("by", [(2.0, 0.0, 0.0), (0.0, -4.0, 0.0), (3.0, 4.0, 3.0)])
def test_a_stretch_that_was_shifted_goes_back_as_a_whole(tmp_path, stretch, by):
    lines = damage.shifted(TRUTH, *stretch, by)
    numbers = set(range(stretch[0], stretch[1] + 1))
    _, text = repaired(tmp_path, lines)
    assert not damage.wrong(text)
    assert untouched(lines, text, numbers)
    assert damage.rmsd(text, TRUTH, numbers) < 0.5 * np.linalg.norm(by)


@pytest.mark.parametrize("number", [1, 14])
def test_an_end_of_the_chain_that_was_shifted_comes_back_alone(tmp_path, number):
    lines = damage.shifted(TRUTH, number, number, [3.0, 2.0, -3.0])
    _, text = repaired(tmp_path, lines)
    assert not damage.wrong(text)
    assert untouched(lines, text, {number})
    atoms = damage.heavy(text)
    if number == 1:
        assert all(abs(np.linalg.norm(atoms[1, "P"] - atoms[1, x]) - 1.55) < 0.15
                   for x in ("O5'", "OP1", "OP2", "OP3"))  # fmt: skip


def test_a_clash_inside_a_strand_is_mended(tmp_path):
    # the base of U7 on the sugar of C8's neighbour
    atoms = damage.heavy(TRUTH)
    step = atoms[4, "C5"] - atoms[7, "C5"]
    base = {x for n, x in atoms if n == 7 and "'" not in x and "P" not in x}
    lines = damage.moved(TRUTH, lambda n, x, at: at + step if n == 7 and x in base else None)
    filling, text = repaired(tmp_path, lines)
    assert any("apart" in sentence for sentence in filling.repaired)
    assert not damage.wrong(text)
    assert untouched(lines, text, {7})


def test_deleted_nucleotides_and_damage_in_one_file(tmp_path):
    lines = damage.mirrored(damage.without(TRUTH, 7, 8), 3)
    filling, text = repaired(tmp_path, lines)
    assert [(s.name, s.sequence, s.sound) for s in filling.strands] == [("A.7-8", "UC", True)]
    assert filling.repairs[0].labels == ("A.C3",)
    assert not damage.wrong(text)
    assert untouched(lines, text, {3, 7, 8})


def test_damage_beside_a_gap_is_mended_before_it_is_filled(tmp_path):
    lines = damage.mirrored(damage.without(TRUTH, 7, 8), 6)
    filling, text = repaired(tmp_path, lines)
    assert filling.repairs[0].labels == ("A.U6",)
    assert filling.strands[0].status == "filled"
    assert not damage.wrong(text)
    assert untouched(lines, text, {6, 7, 8})


def test_what_a_strand_replaces_is_not_repaired_as_well(tmp_path):
    filling, text = repaired(tmp_path, damage.mirrored(TRUTH, 7), strands="A.6-8")
    assert not filling.repairs
    assert not damage.wrong(text)


def test_moved_atoms_are_marked_and_their_hydrogens_left_out(tmp_path):
    lines = damage.mirrored(TRUTH, 9)
    filling, text = repaired(tmp_path, lines)
    mine = [x for x in damage.rows(text) if damage.key(x)[0] == 9]
    built = set(filling.repairs[0].atoms.residues[0].names)
    assert built
    assert {x[54:60].strip() for x in mine if damage.key(x)[1] in built} == {"0.01"}
    left = {damage.key(x)[1] for x in mine if x[76:78].strip() == "H"}
    assert left == {"H8", "H1", "H21", "H22"}
    assert any("A.G9: wrong hand" in x.replace("  ", " ") for x in text if "REMARK  99" in x)


def test_the_order_of_the_lines_stays(tmp_path):
    lines = damage.shifted(TRUTH, 6, 7, [0.0, 4.0, 0.0])
    _, text = repaired(tmp_path, lines)
    heavy = [damage.key(x) for x in damage.rows(lines) if x[76:78].strip() != "H"]
    assert [damage.key(x) for x in damage.rows(text) if x[76:78].strip() != "H"] == heavy


def test_an_atom_that_a_rebuilt_nucleotide_lacks_is_added(tmp_path):
    lines = [x for x in damage.mirrored(TRUTH, 5) if x[:4] != "ATOM" or damage.key(x) != (5, "O4'")]
    _, text = repaired(tmp_path, lines)
    assert not damage.wrong(text)
    assert (5, "O4'") in damage.heavy(text)


def test_atoms_of_old_names_are_moved(tmp_path):
    old = [x.replace(" OP1", " O1P").replace("'", "*") if x[:4] == "ATOM" else x
           for x in damage.mirrored(TRUTH, 5)]  # fmt: skip
    filling, text = repaired(tmp_path, old)
    today = [x.replace(" O1P", " OP1").replace("*", "'") for x in text]
    assert filling.repairs
    assert not damage.wrong(today)


def test_mmcif_comes_back_as_mmcif(tmp_path):
    structure = gemmi.read_pdb_string("\n".join(damage.shifted(TRUTH, 6, 6, [0.0, 3.0, 0.0])))
    structure.setup_entities()
    path = tmp_path / "broken.cif"
    structure.make_mmcif_document().write_file(str(path))
    text = le.fill(path, repair=True).text()
    block = gemmi.cif.read_string(text).sole_block()
    back = gemmi.make_structure_from_block(block).make_pdb_string()
    assert not damage.wrong(back.splitlines())


def test_each_model_is_repaired_by_itself(tmp_path):
    def model(number, lines):
        return [f"MODEL     {number:4d}", *damage.rows(lines), "ENDMDL"]

    lines = [*model(1, TRUTH), *model(2, damage.mirrored(TRUTH, 5)), "END"]
    filling, text = repaired(tmp_path, lines)
    assert [repair.model for repair in filling.repairs] == [2]
    assert filling.repaired[0].startswith("model 2: A.C5")
    end = text.index("ENDMDL")
    assert [x[12:66] for x in damage.rows(text[:end])] == [x[12:66] for x in damage.rows(TRUTH)]
    assert not damage.wrong(text[end + 1 :])


def test_what_cannot_be_mended_is_a_sentence_and_a_failure(tmp_path, monkeypatch):
    # it fails with 8 nucleotides as with 3
    monkeypatch.setattr("loopelastica.filling.repair.LONGEST", 3)
    filling, _ = repaired(tmp_path, damage.shifted(TRUTH, 8, 14, [90.0, 0.0, 0.0]))
    assert not filling.repairs
    (sentence,) = filling.failures
    assert sentence.startswith("A.U7–A.C8: O3'–P 9")
    assert "not mended" in sentence


def test_the_folder_says_what_was_wrong_and_what_was_rebuilt(tmp_path):
    filling, _ = repaired(tmp_path, damage.mirrored(TRUTH, 5))
    out = filling.write(tmp_path / "out")
    (one,) = json.loads((out / "fill.json").read_text())["repaired"]
    assert one["nucleotides"] == ["A.C5"]
    assert one["sound"]
    assert "A.C5: wrong hand at C1'" in one["wrong"]
    assert not damage.wrong((out / "filled.pdb").read_text().splitlines())


def test_a_structure_that_is_turned_is_mended_alike(tmp_path):
    lines = damage.broken(TRUTH, 7, np.array([1.0, 1.0, 1.0]))
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    _, text = repaired(tmp_path, lines)
    _, turned = repaired(tmp_path, damage.moved(lines, lambda _, __, at: turn @ at))
    here, there = damage.heavy(text), damage.heavy(turned)
    assert max(np.abs(turn @ here[k] - there[k]).max() for k in here) < 0.01


@pytest.mark.slow
def test_known_moves_are_found_and_mended_in_nineteen_of_twenty(tmp_path):
    rng = np.random.default_rng(13)
    good = []
    for draw in range(60):
        first = int(rng.integers(2, 12))
        by = rng.normal(size=3)
        by *= rng.uniform(2.0, 6.0) / np.linalg.norm(by)
        last = min(first + int(rng.integers(0, 4)), 13)
        lines, numbers = (
            (damage.broken(TRUTH, first, 0.3 * by), {first}),
            (damage.shifted(TRUTH, first, last, by), set(range(first, last + 1))),
            (damage.mirrored(TRUTH, first), {first}),
            (damage.without(TRUTH, first, first + 1), {first, first + 1}),
        )[draw % 4]
        # a part that is missing is wrong by itself
        if draw % 4 != 3 and not damage.wrong(lines):
            continue
        _, text = repaired(tmp_path, lines)
        good.append(not damage.wrong(text) and untouched(lines, text, numbers))
    assert len(good) > 45
    assert np.mean(good) >= 0.95
