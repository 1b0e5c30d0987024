"""Structure files with faults at random: what reading and folding make of them.

    python tests/fuzz/fuzz.py --files 3000 --seed 1

A file is folded, refused in one line that names it, or has no hairpin; nothing else. Each case has
a number: ``--seed 1 --only 1234 --keep FOLDER`` writes that file and shows what became of it.
"""

from __future__ import annotations

import argparse
import bz2
import functools
import gzip
import math
import re
import resource
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from soak import alarm
from soak_calls import check_candidate, must

import loopelastica as le
from loopelastica._files import data_path

Rng = np.random.Generator
LONGEST_S = 30
MOST_MB = 600
"""The process may grow by this much, imports and compiled code included."""

_SHARED = Path(__file__).resolve().parents[3] / "shared" / "hairpins"
_MORE = ("1zih_rosetta", "1wts_unequal_models", "1d16", "1szy", "boxb_nochain", "430d", "1rnk")
_MODELS = 2
_WORDS = (
    *("****", "nan", "NaN", "inf", "-inf", "1e308", "-1e308", "1e-320", "1e39", "99999999", "-1"),
    *("0", "", "?", ".", "'", '"', ";", "#", "data_", "loop_", "_atom_site.id", "A", "\t", "٣"),
    *("1.5", "1_0", "0x10", "A000", "\x00", "\x85", "\u2028", "é", "x" * 200, "C1'", "P", "HETATM"),
)


# --- what is damaged ------------------------------------------------------------------------------


@functools.cache
def seeds() -> tuple[tuple[str, str], ...]:
    """Suffix and text of sound files: PDB, and mmCIF where gemmi is installed."""
    texts = [data_path("hairpins/2koc.pdb").read_text()]
    for name in _MORE:
        path = _SHARED / f"{name}.pdb.gz"
        if path.is_file():
            texts.append(gzip.decompress(path.read_bytes()).decode())
    pdbs = [_first_models(text) for text in texts]
    return tuple((".pdb", text) for text in pdbs) + tuple((".cif", text) for text in _mmcifs(pdbs))


def _first_models(text: str) -> str:
    parts = text.split("ENDMDL")
    return text if len(parts) <= _MODELS else "ENDMDL".join(parts[:_MODELS]) + "ENDMDL\nEND\n"


def _mmcifs(pdbs: list[str]) -> list[str]:
    try:
        import gemmi
    except ImportError:
        return []
    groups = gemmi.MmcifOutputGroups(False, atoms=True, group_pdb=True, auth_all=True)
    return [gemmi.read_pdb_string(t).make_mmcif_document(groups).as_string() for t in pdbs]


def _is_atom(line: str) -> bool:
    return line.startswith(("ATOM", "HETATM"))


def _atoms(lines: list[str]) -> list[int]:
    return [k for k, line in enumerate(lines) if _is_atom(line)] or list(range(len(lines)))


def _some(rng: Rng, rows: list[int]) -> list[int]:
    """One row, some, a run of them, or all."""
    how = rng.integers(10)
    if not rows:
        return []
    if how < 5:
        return [rows[rng.integers(len(rows))]]
    if how < 7:
        return [k for k in rows if rng.random() < 0.02]
    begin, end = sorted(rng.integers(len(rows) + 1, size=2))
    return rows if how == 7 else rows[begin:end]


def _word(rng: Rng) -> str:
    return str(_WORDS[rng.integers(len(_WORDS))])


# --- faults of lines and fields; each takes the lines and gives lines back ------------------------


def _columns(rng: Rng, lines: list[str]) -> list[str]:
    """Another word in some columns of PDB records."""
    fields = ((0, 6), (6, 11), (12, 16), (16, 17), (17, 20), (21, 22), (22, 26), (26, 27), (30, 38),
              (38, 46), (46, 54), (54, 60), (60, 66), (72, 76), (76, 78), (78, 80))  # fmt: skip
    begin, end = fields[rng.integers(len(fields))]
    word = _word(rng)
    if rng.random() < 0.7:
        word = word[: end - begin].rjust(end - begin)
    for k in _some(rng, _atoms(lines)):
        lines[k] = lines[k][:begin] + word + lines[k][end:]
    return lines


def _tokens(rng: Rng, lines: list[str]) -> list[str]:
    """Another word, one more or one less in a row of mmCIF."""
    rows = _atoms(lines)
    column = rng.integers(max(len(lines[rows[0]].split()), 1))
    word, how = _word(rng) or ".", rng.integers(20)
    for k in _some(rng, rows):
        tokens = lines[k].split()
        if column < len(tokens):
            tokens[column : column + (how != 1)] = [] if how == 0 else [word]
            lines[k] = " ".join(tokens)
    return lines


def _tags(rng: Rng, lines: list[str]) -> list[str]:
    """A column of a loop is missing, is there twice, or has another name."""
    tags = [k for k, line in enumerate(lines) if line.startswith("_atom_site.")]
    if not tags:
        return _deleted(rng, lines)
    k, how = tags[rng.integers(len(tags))], rng.integers(4)
    if how == 0:
        # with its values
        place = tags.index(k)
        for row in _atoms(lines):
            tokens = lines[row].split()
            lines[row] = " ".join(tokens[:place] + tokens[place + 1 :])
        del lines[k]
    elif how == 1:
        del lines[k]
    elif how == 2:
        lines.insert(k, lines[tags[rng.integers(len(tags))]])
    else:
        lines[k] += "x"
    return lines


def _deleted(rng: Rng, lines: list[str]) -> list[str]:
    gone = set(_some(rng, list(range(len(lines)))))
    return [line for k, line in enumerate(lines) if k not in gone]


def _doubled(rng: Rng, lines: list[str]) -> list[str]:
    begin, end = sorted(rng.integers(len(lines) + 1, size=2))
    at = rng.integers(len(lines) + 1)
    return [*lines[:at], *lines[begin:end], *lines[at:]]


def _atoms_doubled(rng: Rng, lines: list[str]) -> list[str]:
    """Rows of atoms once more, elsewhere among them, in another model or under another name."""
    rows = _atoms(lines)
    copies = [lines[k] for k in _some(rng, rows)]
    old, new = (("A", "B"), (" 1", " 2"), (" G ", " C "), ("'", '"'), (" . ", " A "))[
        rng.integers(5)
    ]
    at = rows[rng.integers(len(rows))] if rows else 0
    return [*lines[:at], *(line.replace(old, new) for line in copies), *lines[at:]]


def _shuffled(rng: Rng, lines: list[str]) -> list[str]:
    rows = _some(rng, _atoms(lines))
    for k, line in zip(
        rows, rng.permutation(np.array([lines[k] for k in rows], object)), strict=True
    ):
        lines[k] = line
    return lines


def _inserted(rng: Rng, lines: list[str]) -> list[str]:
    """A record that means something, where it does not belong."""
    records = (
        *(
            "MODEL        1",
            "MODEL",
            "ENDMDL",
            "END",
            "TER",
            "ATOM",
            "HETATM",
            "ANISOU",
            "CRYST1 ****",
        ),
        *("loop_", "data_x", "_atom_site.id", "save_", "stop_", ";", "'", "#", "", " "),
        *("CONECT    1    2", "REMARK " + "x" * 5000, _word(rng)),
    )
    for _ in range(rng.integers(1, 5)):
        lines.insert(rng.integers(len(lines) + 1), str(records[rng.integers(len(records))]))
    return lines


def _shifted(rng: Rng, lines: list[str]) -> list[str]:
    """Lines moved to the left or right, or cut."""
    n = int(rng.integers(1, 60))
    how = rng.integers(3)
    for k in _some(rng, _atoms(lines)):
        lines[k] = (" " * n + lines[k], lines[k][n:], lines[k][:n])[how]
    return lines


def _moved(rng: Rng, lines: list[str]) -> list[str]:
    """Other coordinates: mirrored, collapsed, far away, scaled, at random."""
    how = rng.integers(8)
    at = rng.normal(size=3) * 50
    rows = _some(rng, _atoms(lines))
    for k in rows:
        found = list(re.finditer(r"-?\d+\.\d+", lines[k]))[:3]
        if len(found) < 3:
            continue
        in_columns = lines[k][30:31] == " " and len(lines[k]) > 70
        x = np.array([float(number.group()) for number in found])
        x = (
            *(x * [-1, 1, 1], at, x + 5000, x * 0.0, x * 0.5, x * 1.5),
            *(x + rng.normal(size=3), rng.normal(size=3) * 30),
        )[how]
        for number, value in zip(found[::-1], x[::-1], strict=True):
            width = number.end() - number.start() if in_columns else 0
            new = f"{value:{width}.3f}"
            begin = number.end() - len(new) if in_columns else number.start()
            lines[k] = lines[k][: max(begin, 0)] + new + lines[k][number.end() :]
    return lines


def _many_models(rng: Rng, lines: list[str]) -> list[str]:
    rows = [lines[k] for k in _atoms(lines)][:200]
    n = int(rng.integers(2, 300))
    return [line for k in range(n) for line in (f"MODEL     {k:4d}", *rows, "ENDMDL")]


def _altlocs(rng: Rng, lines: list[str]) -> list[str]:
    """Some atoms twice, with altlocs, insertion codes or another residue name."""
    for k in sorted(_some(rng, _atoms(lines)), reverse=True)[:300]:
        line = lines[k]
        lines[k] = f"{line[:16]}A{line[17:]}"
        other = f"{line[:16]}B{line[17:]}"
        if rng.random() < 0.2:
            other = f"{line[:17]}  X{line[20:26]}Z{line[27:]}"
        lines.insert(k + 1, other)
    return lines


_Fault = Callable[[Rng, list[str]], list[str]]
_ANY: tuple[_Fault, ...] = (_deleted, _doubled, _shuffled, _inserted, _shifted)
_FAULTS: dict[str, tuple[_Fault, ...]] = {
    ".pdb": (*_ANY, _columns, _columns, _columns, _columns, _moved, _moved, _many_models, _altlocs),
    ".cif": (*_ANY, *(4 * (_tokens,)), *(3 * (_moved,)), *(3 * (_atoms_doubled,)), _tags, _tags),
}


# --- faults of bytes ------------------------------------------------------------------------------


def _bytes(rng: Rng, data: bytes) -> bytes:
    """Line ends, single bytes, an end too early."""
    how = rng.integers(30)
    if how == 0:
        return data.replace(b"\n", b"\r\n")
    if how == 1:
        return data.replace(b"\n", b"\r")
    if how == 2:
        return data.rstrip(b"\n")
    if how == 3:
        return data[: rng.integers(len(data) + 1)]
    if how == 4:
        return b"\xef\xbb\xbf" + data
    if how == 5:
        return data.replace(b" ", b"\t", int(rng.integers(1, 2000)))
    if how in (6, 7):
        changed = bytearray(data)
        for place in rng.integers(max(len(data), 1), size=rng.integers(1, 30)):
            if place < len(changed):
                changed[place] = rng.integers(256)
        return bytes(changed)
    return data


def _packed(rng: Rng, data: bytes) -> tuple[str, bytes]:
    how = rng.integers(40)
    if how == 0:
        return ".gz", gzip.compress(data, 1, mtime=0)
    if how == 1:
        packed = gzip.compress(data, 1, mtime=0)
        return ".gz", packed[: rng.integers(len(packed) + 1)]
    if how == 2:
        return ".gz", _bytes(
            np.random.default_rng(rng.integers(99)), gzip.compress(data, 1, mtime=0)
        )
    if how == 3:
        packed = bz2.compress(data)
        return ".bz2", packed[: rng.integers(len(packed) + 1)]
    return "", data


@dataclass(frozen=True)
class Case:
    """A file to be: its suffix and its content."""

    suffix: str
    content: bytes


def case(seed: int, number: int) -> Case:
    """The file of that number."""
    rng = np.random.default_rng([seed, number])
    suffix, text = seeds()[rng.integers(len(seeds()))]
    lines = text.split("\n")
    for _ in range(rng.choice([1, 1, 2, 3])):
        if lines:
            faults = _FAULTS[suffix]
            lines = faults[rng.integers(len(faults))](rng, lines)
    data = _bytes(rng, "\n".join(lines).encode("utf-8", "surrogatepass"))
    packing, data = _packed(rng, data)
    return Case(suffix + packing, data)


# --- what becomes of it ---------------------------------------------------------------------------


def outcome(path: Path) -> str:
    """What became of a file, in a word.

    Raises
    ------
    BaseException
        If it is anything but a fold or a sentence that names the file.
    """
    with warnings.catch_warnings(), alarm(LONGEST_S):
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", category=UserWarning, module="loopelastica")
        warnings.filterwarnings("ignore", category=DeprecationWarning)
        try:
            hairpins = le.find_hairpins(path)
            for remark in hairpins.remarks:
                must("\n" not in remark, "a remark of two lines")
            if not hairpins:
                return "no hairpin"
            loops = le.fold(path, all_models=False, max_candidates=1)
        except le.LoopelasticaError as error:
            sentence = str(error)
            must(sentence.isprintable(), f"not one line: {sentence!r}")
            must(sentence.startswith(str(path)), f"no name of the file: {sentence}")
            located = re.search(r"gemmi cannot read it \((line|row) \d+[: ]", sentence)
            must("cannot read it" not in sentence or located, f"no line and no row: {sentence}")
            must(len(sentence) < len(str(path)) + 300, f"a sentence without end: {sentence}")
            return "refused"
    for loop in loops:
        must(loop.failure is None or loop.failure.isprintable(), f"not one line: {loop.failure!r}")
        must((loop.failure is None) == bool(loop.candidates), "failure or candidates")
        for candidate in loop.candidates:
            check_candidate(candidate)
        must(math.isfinite(loop.unseen), "unseen")
    return "folded" if any(loop.candidates for loop in loops) else "not folded"


def fuzz(seed: int, numbers: range, folder: Path) -> tuple[Counter[str], list[str]]:
    """Outcomes of the files of these numbers, and a line for each that is not as it should be."""
    outcomes: Counter[str] = Counter()
    faults = []
    before_MB = _peak_MB()
    for number in numbers:
        made = case(seed, number)
        path = folder / f"case_{seed}_{number}{made.suffix}"
        path.write_bytes(made.content)
        try:
            outcomes[outcome(path)] += 1
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            what = " ".join(f"{type(error).__name__}: {error}".split())[:300]
            place = f"{Path(where.filename).name}:{where.lineno}"
            faults.append(f"--seed {seed} --only {number}: {what} ({place})")
            outcomes["FAULT"] += 1
        path.unlink()
    if _peak_MB() > before_MB + MOST_MB:
        faults.append(f"the process has come to {_peak_MB():.0f} MB from {before_MB:.0f} MB")
    return outcomes, faults


def _peak_MB() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> int:
    """Fuzz from the command line; exit status 1 if anything was not as it should be."""
    parser = argparse.ArgumentParser(description="Fold files with faults at random.")
    parser.add_argument("--files", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="this file only, with the traceback")
    parser.add_argument("--keep", type=Path, help="folder that it is written to")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        if given.only is not None:
            made = case(given.seed, given.only)
            path = (given.keep or Path(scratch)) / f"case_{given.seed}_{given.only}{made.suffix}"
            path.write_bytes(made.content)
            print(path, outcome(path))
            return 0
        outcomes, faults = fuzz(given.seed, range(given.files), Path(scratch))
    print(dict(outcomes))
    print("\n".join(faults))
    return int(bool(faults))


if __name__ == "__main__":
    raise SystemExit(main())
