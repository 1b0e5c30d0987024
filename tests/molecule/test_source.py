"""What is no regular file, and what is too large, becomes a sentence before it does any harm."""

from __future__ import annotations

import bz2
import gzip
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

import loopelastica as le
from loopelastica.errors import StructureError
from loopelastica.molecule.nucleotides import Limits, quiet, read_structure

KOC = Path(__file__).parents[2] / "data" / "hairpins" / "2koc.pdb"


def fault_of(path, limits=None) -> str:
    with pytest.raises(StructureError) as caught:
        read_structure(path, limits)
    sentence = str(caught.value)
    assert sentence.startswith(str(path))
    assert "\n" not in sentence
    return sentence


@pytest.mark.parametrize("name", ["pipe.pdb", "pipe.pdb.gz", "pipe.cif", "pipe.gro", "pipe"])
def test_a_pipe_is_refused_and_not_waited_for(tmp_path, name):
    path = tmp_path / name
    os.mkfifo(path)
    assert "this is a pipe" in fault_of(path)


@pytest.mark.parametrize("call", [le.fold, le.scan, le.find_hairpins])
def test_no_public_function_waits_for_a_pipe(tmp_path, call):
    path = tmp_path / "pipe.pdb"
    os.mkfifo(path)
    with pytest.raises(StructureError, match="pipe"):
        call(path)


def test_devices_sockets_and_folders_are_refused(tmp_path):
    link = tmp_path / "zero.pdb"
    link.symlink_to("/dev/zero")
    assert "this is a device" in fault_of(link)
    assert "this is a device" in fault_of(Path("/dev/null"))
    assert "this is a folder" in fault_of(tmp_path)
    path = tmp_path / "s.pdb"
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(os.fspath(path))
        assert "this is a socket" in fault_of(path)


def test_a_link_to_a_file_is_read(tmp_path):
    link = tmp_path / "link.pdb"
    link.symlink_to(KOC)
    assert read_structure(link).n_models == 20
    (tmp_path / "nowhere.pdb").symlink_to(tmp_path / "absent")
    assert "no such file" in fault_of(tmp_path / "nowhere.pdb")


def test_names_that_no_file_can_have():
    for name, shown in (("a\0b.pdb", r"a\x00b.pdb"), ("a" * 5000 + ".pdb", "a" * 100)):
        with pytest.raises(StructureError, match="cannot be read") as caught:
            read_structure(name)
        assert str(caught.value).startswith(shown)
        assert len(str(caught.value)) < 400


def test_a_name_of_two_lines_is_shown_in_one(tmp_path):
    path = tmp_path / "two\nlines\udc80.pdb"
    path.write_bytes(b"no structure")
    for call in (le.fold, le.find_hairpins):
        with pytest.raises(StructureError) as caught:
            call(path)
        assert r"two\nlines\udc80.pdb: no ATOM" in str(caught.value)
        assert str(caught.value).isprintable()


@pytest.mark.parametrize("compress", [gzip.compress, bz2.compress, bytes])
@pytest.mark.parametrize("suffix", [".pdb", ".cif", ".gro"])
def test_the_size_counts_after_decompression(tmp_path, compress, suffix):
    ending = {gzip.compress: ".gz", bz2.compress: ".bz2", bytes: ""}[compress]
    path = tmp_path / f"bomb{suffix}{ending}"
    path.write_bytes(compress(b"\n" * 3_000_000))
    sentence = fault_of(path, Limits(max_size_MB=2.5))
    assert "2.5 MB" in sentence
    assert "max_size_MB" in sentence
    assert "`max_size_MB`" in sentence


def test_options_raise_and_lower_the_limits(tmp_path):
    for call in (le.fold, le.scan, le.find_hairpins):
        with pytest.raises(StructureError, match=r"2koc\.pdb.*0\.5 MB.*max_size_MB"):
            call(KOC, max_size_MB=0.5)
        with pytest.raises(StructureError, match=r"2koc\.pdb.*450 atoms.*max_atoms"):
            call(KOC, max_atoms=450)
        for name in ("max_size_MB", "max_atoms"):
            for value in (0, -1, float("nan"), float("inf"), "1", None, True, 10**400):
                with pytest.raises(ValueError, match=f"`{name}`"):
                    call(KOC, **{name: value})
    assert len(le.find_hairpins(KOC, max_size_MB=1, max_atoms=451)) == 1


def test_atoms_of_mmcif_and_of_other_formats_are_counted(tmp_path, koc):
    gemmi = pytest.importorskip("gemmi")
    path = tmp_path / "2koc.cif"
    gemmi.read_pdb(str(KOC)).make_mmcif_document().write_file(str(path))
    assert "450 atoms" in fault_of(path, Limits(max_atoms=450))
    assert read_structure(path, Limits(max_atoms=451)).n_models == 20
    gro = tmp_path / "2koc.gro"
    with quiet():
        koc.universe.atoms.write(str(gro))
    assert "450 atoms" in fault_of(gro, Limits(max_atoms=450))
    assert len(read_structure(gro, Limits(max_atoms=451)).nucleotides) == 14


def test_formats_that_open_other_files_are_not_read(tmp_path):
    secret = tmp_path / "secret.txt"
    os.mkfifo(secret)
    for suffix in (".itp", ".top", ".psf", ".xtc", ".parm7", ""):
        path = tmp_path / f"some{suffix}"
        path.write_text('#include "secret.txt"\n')
        assert "MDAnalysis cannot read" in fault_of(path)
    assert sorted(p.suffix for p in tmp_path.iterdir() if p.name.startswith(".")) == []


_MEASURED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
import MDAnalysis, scipy.spatial
from loopelastica.errors import StructureError
from loopelastica.molecule.hairpins import find_hairpins
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
before = peak()
try:
    find_hairpins(sys.argv[1])
except StructureError as error:
    print(error, file=sys.stderr)
print((peak() - before) / 1024)
"""


def growth_MB(path: Path) -> float:
    """Memory that a process of its own takes for reading a file, beyond that for importing."""
    ran = subprocess.run(
        [sys.executable, "-c", _MEASURED, str(path)],
        capture_output=True,
        text=True,
        check=True,
        timeout=100,
    )
    return float(ran.stdout)


def test_blanks_by_the_megabyte_take_no_memory(tmp_path):
    for name, blanks in (("lines.pdb.gz", b"\n"), ("line.pdb.gz", b" "), ("blank.cif.gz", b"\n")):
        path = tmp_path / name
        path.write_bytes(gzip.compress(blanks * 50_000_000, 1))
        assert growth_MB(path) < 50.0


def test_memory_of_many_atoms_is_in_proportion(tmp_path, koc_lines):
    path = tmp_path / "many.pdb"
    n = 100
    with path.open("w") as file:
        for k in range(n):
            for line in koc_lines:
                x = float(line[30:38]) + 80 * k
                file.write(f"{line[:21]}{'ABCDEFG'[k % 7]}{line[22:30]}{x:8.2f}{line[38:]}\n")
    assert growth_MB(path) < 20.0 * path.stat().st_size / 1e6 + 20.0


def test_models_take_memory_for_their_coordinates_only(tmp_path, koc_lines):
    path = tmp_path / "models.pdb"
    model = "\n".join(["MODEL", *koc_lines, "ENDMDL", ""])
    path.write_text(model * 500)
    assert growth_MB(path) < 2.0 * path.stat().st_size / 1e6 + 20.0


def test_bases_in_one_place_are_refused_before_they_are_paired(tmp_path, koc_lines):
    path = tmp_path / "same.pdb"
    letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    copies = [f"{x[:21]}{letters[k % 26]}{x[22:]}" for k in range(120) for x in koc_lines]
    path.write_text("\n".join(copies))
    with pytest.raises(StructureError, match=r"same\.pdb.*pairs of bases") as caught:
        le.find_hairpins(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        (".gro", "x\n 999999999\n    1G      P    1   0.000   0.000   0.000\n"),
        (".xyz", "999999999\nx\nP 0 0 0\n"),
        (".txyz", "999999999 x\n1 P 0 0 0 1\n"),
        (".crd", "* x\n*\n 999999999 EXT\n"),
        (".mol2", "@<TRIPOS>MOLECULE\nx\n999999999 0\nSMALL\nNO_CHARGES\n@<TRIPOS>ATOM\n"),
        (".data", "x\n\n999999999 atoms\n\nAtoms\n\n1 1 1 0 0 0\n"),
        (".lammpsdump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n999999999\n"),
    ],
)
def test_no_room_is_made_for_atoms_that_a_head_invents(tmp_path, suffix, text):
    path = tmp_path / f"head{suffix}"
    path.write_text(text)
    assert "1,000,000 atoms" in fault_of(path)
