import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import oracle
import pytest
import strands

from loopelastica._files import OutputError
from loopelastica.errors import StructureError
from loopelastica.nanostructures.oxdna.energies import bonds, energies
from loopelastica.nanostructures.oxdna.files import find_files, read_oxdna, write_oxdna


@pytest.fixture
def hairpin(tmp_path):
    """A hairpin in a box, written by other means and with more digits than needed."""
    system = strands.hairpin("GCGTAC", "TTTTTT")
    n = len(system)
    lines = ["t = 5000", "b = 30.0 31.0 32.0", "E = -1.25 -1.5 0.25"]
    rows = np.concatenate([system.centre, system.a1, system.a3], axis=1)
    for k, row in enumerate(rows.tolist()):
        lines.append("  ".join(f"{x:+.15e}" for x in row) + f" {k} 0.5 -0.25 1e-3 0 1")
    (tmp_path / "pin.dat").write_text("\n".join(lines) + "\n")
    columns = zip(system.base, system.n3, system.n5, strict=True)
    top = [f"{n} 1"] + [f"1 {b} {p} {q}" for b, p, q in columns]
    (tmp_path / "pin.top").write_text("\n".join(top) + "\n")
    return tmp_path / "pin.top"


def lines_of(path):
    return Path(path).read_text().splitlines()


def test_a_pair_of_files_is_read_with_its_pairs(hairpin):
    files = read_oxdna(hairpin)
    made = strands.hairpin("GCGTAC", "TTTTTT")
    np.testing.assert_allclose(files.system.centre, made.centre, atol=1e-14)
    np.testing.assert_array_equal(files.system.pair[:6], np.arange(17, 11, -1))
    assert (files.system.pair[6:12] == -1).all()
    assert files.system.placed.all()
    assert files.system.name == str(hairpin)
    assert files.system.label[3] == "nucleotide 3"


def test_either_file_finds_the_other(hairpin):
    dat = hairpin.with_suffix(".dat")
    for given in ((hairpin,), (dat,), (hairpin, dat), (dat, hairpin), (str(dat), None)):
        assert find_files(*given) == (hairpin, dat)


def test_configurations_of_other_suffixes_are_found(hairpin):
    for suffix in (".oxdna", ".conf"):
        hairpin.with_suffix(".dat").rename(hairpin.with_suffix(suffix))
        assert find_files(hairpin)[1].suffix == suffix
        hairpin.with_suffix(suffix).rename(hairpin.with_suffix(".dat"))


def test_compressed_files_find_each_other(hairpin):
    import gzip

    for path in (hairpin, hairpin.with_suffix(".dat")):
        path.with_name(f"{path.name}.gz").write_bytes(gzip.compress(path.read_bytes()))
    dat = hairpin.with_suffix(".dat")
    packed = hairpin.with_name("pin.top.gz")
    assert find_files(packed) == (packed, dat)
    assert find_files(packed, dat.with_name("pin.dat.gz")) == (packed, dat.with_name("pin.dat.gz"))
    assert len(read_oxdna(packed).system) == 18
    dat.unlink()
    for given in (hairpin, packed):
        assert find_files(given) == (given, dat.with_name("pin.dat.gz"))


def test_nothing_changed_is_written_to_the_byte(hairpin, tmp_path):
    files = read_oxdna(hairpin)
    write_oxdna(files.system, tmp_path / "out.top", tmp_path / "out.dat", files=files)
    assert (tmp_path / "out.top").read_bytes() == hairpin.read_bytes()
    assert (tmp_path / "out.dat").read_bytes() == hairpin.with_suffix(".dat").read_bytes()


def test_lines_that_end_as_on_windows_are_kept(hairpin, tmp_path):
    dat = hairpin.with_suffix(".dat")
    dat.write_bytes(dat.read_bytes().replace(b"\n", b"\r\n"))
    files = read_oxdna(hairpin)
    moved = replace(files.system, centre=files.system.centre + np.eye(18)[:, 7:8] * 0.1)
    write_oxdna(moved, tmp_path / "out.top", tmp_path / "out.dat", files=files)
    written = (tmp_path / "out.dat").read_bytes().split(b"\n")
    assert all(line.endswith(b"\r") for line in written[:-1])
    assert read_oxdna(tmp_path / "out.top").system.centre[7] == pytest.approx(moved.centre[7])


def test_what_has_not_moved_keeps_its_line(hairpin, tmp_path):
    files = read_oxdna(hairpin)
    loose = files.system.pair < 0
    centre = np.where(loose[:, None], files.system.centre + 0.01, files.system.centre)
    moved = replace(files.system, centre=centre)
    write_oxdna(moved, tmp_path / "out.top", tmp_path / "out.dat", files=files)
    before, after = lines_of(hairpin.with_suffix(".dat")), lines_of(tmp_path / "out.dat")
    assert after[:2] == before[:2]
    assert after[2] == "E = 0 0 0"
    for is_loose, old, new in zip(loose, before[3:], after[3:], strict=True):
        assert (old != new) == is_loose
        assert old.split()[9:] == new.split()[9:]
    np.testing.assert_allclose(read_oxdna(tmp_path / "out.top").system.centre, centre, atol=1e-11)


def test_the_new_form_lists_strands_from_5_to_3(hairpin, tmp_path):
    # the file the way round that the program's documentation lists strands: from 3' to 5'
    files = read_oxdna(hairpin)
    s = files.system
    back = np.arange(18)[::-1]
    turned = replace(
        s,
        **{x: getattr(s, x)[back] for x in ("base", "centre", "a1", "a3")},
        n3=np.arange(-1, 17),
        n5=np.append(np.arange(1, 18), -1),
    )
    write_oxdna(turned, tmp_path / "old.top", tmp_path / "old.dat")
    old = read_oxdna(tmp_path / "old.top")
    write_oxdna(old.system, tmp_path / "new.top", tmp_path / "new.dat", form="new", files=old)
    assert lines_of(tmp_path / "new.top") == ["18 1 5->3", "GCGTACTTTTTTGTACGC type=DNA"]
    assert lines_of(tmp_path / "new.dat")[3:] == lines_of(tmp_path / "old.dat")[3:][::-1]
    new = read_oxdna(tmp_path / "new.dat")
    np.testing.assert_allclose(new.system.centre, s.centre, atol=1e-10)
    np.testing.assert_array_equal(new.system.pair, s.pair)
    # and its own form again: names of strands and all
    write_oxdna(new.system, tmp_path / "c.top", tmp_path / "c.dat", form="new", files=new)
    assert (tmp_path / "c.top").read_bytes() == (tmp_path / "new.top").read_bytes()
    assert (tmp_path / "c.dat").read_bytes() == (tmp_path / "new.dat").read_bytes()


def wrapped(path, images):
    """Files with nucleotides moved by sides of the box."""
    dat = path.with_suffix(".dat")
    lines = lines_of(dat)
    box = np.array([30.0, 31.0, 32.0])
    for k, image in enumerate(images):
        words = lines[3 + k].split()
        place = np.array(words[:3], dtype=float) + image * box
        words[:3] = [f"{x:.15e}" for x in place]
        lines[3 + k] = " ".join(words)
    dat.write_text("\n".join(lines) + "\n")


def test_a_strand_across_the_box_is_made_whole_and_written_as_it_was(hairpin, tmp_path, rng):
    whole = read_oxdna(hairpin).system
    wrapped(hairpin, rng.integers(-1, 2, size=(18, 3)))
    files = read_oxdna(hairpin)
    np.testing.assert_array_equal(files.system.pair, whole.pair)
    steps = np.diff(files.system.centre, axis=0)
    np.testing.assert_allclose(steps, np.diff(whole.centre, axis=0), atol=1e-9)
    write_oxdna(files.system, tmp_path / "out.top", tmp_path / "out.dat", files=files)
    assert lines_of(tmp_path / "out.dat") == lines_of(hairpin.with_suffix(".dat"))


def test_a_moved_nucleotide_stays_in_the_image_of_its_strand(hairpin, tmp_path):
    # the whole strand outside of the box, as the program leaves it
    wrapped(hairpin, np.tile([2, 0, -1], (18, 1)))
    files = read_oxdna(hairpin)
    moved = replace(files.system, centre=files.system.centre + np.eye(18)[:, 8:9] * 0.01)
    write_oxdna(moved, tmp_path / "out.top", tmp_path / "out.dat", files=files)
    x = [float(line.split()[0]) for line in lines_of(tmp_path / "out.dat")[3:]]
    assert np.ptp(x) < 5
    assert min(x) > 50


def test_a_moved_nucleotide_of_a_strand_across_the_box_stays_on_its_side(hairpin, tmp_path):
    wrapped(hairpin, np.where(np.arange(18)[:, None] > 8, [1, -1, 0], [0, 0, 0]))
    files = read_oxdna(hairpin)
    moved = replace(files.system, centre=files.system.centre + np.eye(18)[:, 10:11] * 0.01)
    write_oxdna(moved, tmp_path / "out.top", tmp_path / "out.dat", files=files)
    there, here = (
        np.array(lines_of(path)[13].split()[:3], dtype=float)
        for path in (hairpin.with_suffix(".dat"), tmp_path / "out.dat")
    )
    np.testing.assert_allclose(here - there, 0.01, atol=1e-9)


def test_two_strands_of_a_pair_are_brought_together(tmp_path):
    system = strands.helix("GCATTGCAGC", box=(25.0, 25.0, 25.0))
    apart = np.where(system.strand[:, None] == 1, system.centre + [25.0, -50.0, 0], system.centre)
    write_oxdna(replace(system, centre=apart), tmp_path / "a.top", tmp_path / "a.dat")
    found = read_oxdna(tmp_path / "a.top").system
    gap = np.linalg.norm(found.centre[found.pair] - found.centre, axis=1)
    np.testing.assert_allclose(gap, 1.2, atol=1e-9)


def test_a_design_gets_a_box_with_room_around_it(tmp_path):
    system = strands.helix("GCATTGCAGC" * 10)
    write_oxdna(system, tmp_path / "a.top", tmp_path / "a.dat")
    box = read_oxdna(tmp_path / "a.top").system.box
    assert (box > np.linalg.norm(np.ptp(system.centre, axis=0)) + 10).all()
    assert np.ptp(box) == 0


def test_a_system_with_a_lost_nucleotide_is_not_written(tmp_path):
    system = strands.helix("ACGT")
    lost = replace(system, placed=np.arange(8) != 5)
    centre = system.centre.copy()
    centre[5] = np.nan
    for wrong in (lost, replace(system, centre=centre)):
        with pytest.raises(ValueError, match="nucleotide 5 has no place"):
            write_oxdna(wrong, tmp_path / "a.top", tmp_path / "a.dat")
    assert list(tmp_path.iterdir()) == []


def test_inputs_are_never_written_over(hairpin, tmp_path):
    files = read_oxdna(hairpin)
    before = hairpin.read_bytes()
    for top, dat in (
        (hairpin, tmp_path / "x.dat"),
        (tmp_path / "x.top", hairpin.with_suffix(".dat")),
    ):
        with pytest.raises(OutputError, match="is the input"):
            write_oxdna(files.system, top, dat, files=files)
    assert hairpin.read_bytes() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["pin.dat", "pin.top"]


def test_a_form_that_is_none_is_refused(tmp_path):
    with pytest.raises(ValueError, match="`form`"):
        write_oxdna(strands.helix("AC"), tmp_path / "a.top", tmp_path / "a.dat", form="3->5")


def test_missing_files_are_named(tmp_path):
    with pytest.raises(StructureError, match=r"no a\.dat or a\.oxdna or a\.conf beside it"):
        read_oxdna(tmp_path / "a.top")
    with pytest.raises(StructureError, match=r"no b\.top beside it"):
        read_oxdna(tmp_path / "b.dat")
    with pytest.raises(StructureError, match=r"a\.top: there is no such file"):
        read_oxdna(tmp_path / "a.top", tmp_path / "a.dat")
    with pytest.raises(StructureError, match="both are topologies"):
        read_oxdna(tmp_path / "a.top", tmp_path / "b.top")
    with pytest.raises(StructureError, match="both are configurations"):
        read_oxdna(tmp_path / "a.dat", tmp_path / "b.dat")
    with pytest.raises(ValueError, match="`path`"):
        read_oxdna("")


@pytest.mark.parametrize("suffix", [".top", ".dat"])
def test_files_of_something_else_are_refused(hairpin, suffix):
    path = hairpin.with_suffix(suffix)
    for content, says in (
        (b"", "empty"),
        (b"\n \n", "empty"),
        (os.urandom(999) + b"\0", "no text"),
    ):
        path.write_bytes(content)
        with pytest.raises(StructureError, match=f"pin{suffix}: .*{says}") as refusal:
            read_oxdna(hairpin)
        assert "\n" not in str(refusal.value)
    path.unlink()
    path.mkdir()
    with pytest.raises(StructureError, match="a folder"):
        read_oxdna(hairpin)


def test_files_damaged_at_random_are_read_or_refused_in_a_sentence(hairpin, tmp_path, rng):
    whole = {path: path.read_bytes() for path in (hairpin, hairpin.with_suffix(".dat"))}
    bits = [b"nan", b"-1", b"1e308", b"\n", b" ", b"t = 0\n", b"99999999999", b"\xc2\xb2", b"5->3"]
    sentences, n_read = [], 0
    for k in range(200):
        path = list(whole)[k % 2]
        content = bytearray(whole[path])
        place = int(rng.integers(len(content)))
        content[place : place + int(rng.integers(4))] = bits[int(rng.integers(len(bits)))]
        path.write_bytes(content)
        try:
            files = read_oxdna(hairpin)
            write_oxdna(files.system, tmp_path / "out.top", tmp_path / "out.dat", files=files)
            n_read += 1
        except StructureError as refusal:
            sentences.append(str(refusal))
        path.write_bytes(whole[path])
    assert all("pin." in sentence and "\n" not in sentence for sentence in sentences)
    assert n_read
    assert len(sentences) > 50


def test_a_written_start_runs(tmp_path):
    """Ten thousand steps of dynamics in LAMMPS from the files, at 300 K."""
    made = strands.hairpin("GCGTAC", "TTTTTT")
    write_oxdna(made, tmp_path / "pin.top", tmp_path / "pin.dat")
    start = read_oxdna(tmp_path / "pin.top").system
    centre, energy = oracle.run(start, tmp_path, 10_000)
    assert np.isfinite(centre).all()
    assert np.isfinite(energy)
    # warm by 6 kT/2 a nucleotide at most, not blown up
    assert energy < sum(energies(start).values()) + len(start) * 3 * 0.1 + 2
    assert np.isfinite(bonds(start).backbone).all()
