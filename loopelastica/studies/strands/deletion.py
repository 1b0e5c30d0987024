"""Strands taken out and filled again, beside simpler curves and PDBFixer: one run, one sample."""

from __future__ import annotations

import random
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from loopelastica._arrays import Array
from loopelastica._files import write_csv, write_json, write_text
from loopelastica.errors import LoopelasticaError
from loopelastica.filling.models import strand_models
from loopelastica.folding.expected import expected_rmsd, length_class, signs
from loopelastica.folding.line import strand_lines
from loopelastica.molecule.entry import Entry, read_entry
from loopelastica.molecule.flanks import gap_between
from loopelastica.molecule.folders import structure_files
from loopelastica.molecule.gaps import find_gaps
from loopelastica.molecule.nucleotides import BACKBONE
from loopelastica.molecule.obstacles import crowding, obstacles
from loopelastica.molecule.polymer import Gap, HeavyAtoms
from loopelastica.molecule.strand_ends import StrandEnds, strand_ends
from loopelastica.molecule.surroundings import heavy_atoms
from loopelastica.molecule.trace import loop_arc_positions, rmsd_A
from loopelastica.rod.clamping import Clamping
from loopelastica.rod.curves import equal_length_hermite
from loopelastica.rod.solve import solve
from loopelastica.studies.strands.calibration import calibrated, covered
from loopelastica.studies.strands.report import report
from loopelastica.studies.strands.selection import Cut, cuts, distinct

_SEED: Final = 2026


def run(
    folders: Sequence[Path],
    out: Path,
    *,
    sample: int = 12,
    pdbfixer: bool = False,
    progress: bool = False,
) -> str:
    """Measure; write ``strands.csv`` (a row per strand), ``strands.md`` and ``calibration.json``.

    The last is the table of :mod:`loopelastica.folding.expected` as these strands give it, and how
    often its intervals hold on entries that it has not seen.

    Parameters
    ----------
    folders : sequence of Path
        PDB and mmCIF files, gzipped or not.
    out : Path
        Folder for the results.
    sample : int
        Most strands of each kind, type and class of length; families and copies count once.
    pdbfixer : bool
        Fill the same strands with PDBFixer too, in what is within 12 Å of them.
    progress : bool
        Show a bar.

    Returns
    -------
    str
        The tables.

    Raises
    ------
    ValueError
        If a folder holds no such file.
    """
    from loopelastica._progress import progress_bar

    found = distinct(
        [cut for folder in folders for f in structure_files(folder) for cut in cuts(f)]
    )
    chosen = _sampled(found, sample)
    rows: list[dict[str, Any]] = []
    with progress_bar(total=sum(map(len, chosen.values())), shown=progress, unit="strand") as bar:
        for file, own in chosen.items():
            for row in _file(file, own, pdbfixer):
                rows.append(row)
                bar.update()
                # a table that grows: the study takes an hour
                if len(rows) % 25 == 0:
                    _write(out, rows)
    _write(out, rows)
    text = report(rows)
    write_text(out / "strands.md", text)
    write_json(out / "calibration.json", {"table": calibrated(rows), "covered": covered(rows)})
    return text


def _write(out: Path, rows: list[dict[str, Any]]) -> None:
    if rows:
        write_csv(out / "strands.csv", rows, list(dict.fromkeys(k for row in rows for k in row)))


def _sampled(found: list[Cut], most: int) -> dict[Path, list[Cut]]:
    """Some of each kind, type and class, spread over the files as evenly as can be."""
    groups: dict[tuple[str, str, str], list[Cut]] = defaultdict(list)
    for cut in found:
        groups[cut.kind, cut.type, length_class(cut.n)].append(cut)
    chooser = random.Random(_SEED)
    chosen: dict[Path, list[Cut]] = defaultdict(list)
    for group in groups.values():
        chooser.shuffle(group)
        seen: dict[Path, int] = defaultdict(int)
        turns = []
        for cut in group:
            turns.append((seen[cut.file], cut))
            seen[cut.file] += 1
        for _, cut in sorted(turns, key=lambda turn: turn[0])[:most]:
            chosen[cut.file].append(cut)
    return chosen


def _file(file: Path, own: Sequence[Cut], pdbfixer: bool) -> Iterator[dict[str, Any]]:
    try:
        entry = read_entry(file)
        atoms = heavy_atoms(entry)
        gaps = dict(_gaps(entry, own))
    except LoopelasticaError as error:
        yield from ({**_about(cut), "failure": str(error)} for cut in own)
        return
    for cut in own:
        gap = gaps.get(cut.name)
        row = _about(cut)
        if gap is None:
            row["failure"] = "not found among the chains"
        else:
            try:
                row |= _measured(gap, atoms.without({m.label for m in gap.replaces}))
            except LoopelasticaError as error:
                row["failure"] = str(error)
            if pdbfixer and "failure" not in row:
                from loopelastica.studies.strands.peer import filled_by_pdbfixer

                row |= filled_by_pdbfixer(gap, atoms.without({m.label for m in gap.replaces}))
        yield row


def _about(cut: Cut) -> dict[str, Any]:
    return {
        "file": cut.file.name,
        "strand": cut.name,
        "kind": cut.kind,
        "type": cut.type,
        "n": cut.n,
        "class": length_class(cut.n),
        "context": cut.context,
    }


def _gaps(entry: Entry, own: Sequence[Cut]) -> Iterator[tuple[str, Gap]]:
    """Strands that are there as gaps, by their names."""
    from dataclasses import replace

    lengths = {cut.n for cut in own}
    wanted = {cut.name for cut in own}
    for chain in find_gaps(entry).chains:
        for n in lengths:
            for i in range(len(chain.slots) - n - 1):
                monomers = chain.slots[i + 1 : i + n + 1]
                if not all(m.atoms_A for m in chain.slots[i : i + n + 2]):
                    continue
                gap = gap_between(chain, i, i + n + 1)
                if gap.name in wanted and gap.before.usable and gap.after.usable:
                    missing = tuple(replace(m, atoms_A={}) for m in monomers)
                    yield gap.name, replace(gap, monomers=missing, replaces=monomers, remarks=())


def _measured(gap: Gap, atoms: HeavyAtoms) -> dict[str, Any]:
    native = np.array([monomer.backbone_A.mean(axis=0) for monomer in gap.replaces])
    ends = strand_ends(gap)
    around = atoms.positions_A[obstacles(gap, ends, atoms)]
    crowded = crowding(ends, around)
    row: dict[str, Any] = {
        "distance_A": ends.distance_A,
        "length_A": ends.length_A,
        "crowding": crowded,
        **{f"rmsd_{k}_A": rmsd_A(points, native) for k, points in _curves(ends).items()},
    }
    begin = time.process_time()
    lines = strand_lines(gap, ends, atoms, 5)
    row["lines_s"] = time.process_time() - begin
    row["minima"] = len(lines)
    row["rmsd_line_A"] = rmsd_A(lines[0].trace, native)
    row["rmsd_best_of_five_A"] = min(rmsd_A(line.trace, native) for line in lines)
    row["nearest_A"] = lines[0].nearest_A
    row["energy"] = lines[0].rod.energy
    row["signs"] = [round(float(value), 4) for value in signs(lines[0], crowded)]
    low, middle, high = expected_rmsd(lines[0], crowded)
    row |= {"expected_10_A": low, "expected_50_A": middle, "expected_90_A": high}
    begin = time.process_time()
    ((_, model),) = strand_models(gap, ends, atoms)
    row["whole_s"] = time.process_time() - begin
    built = {(m.monomer.place, name): at for m in model.residues
             for name, at in zip(m.names, m.positions_A, strict=True)}  # fmt: skip
    own = np.array([[built[m.place, name] for name in BACKBONE] for m in gap.monomers])
    checks = model.checks
    return row | {
        "rmsd_atoms_A": rmsd_A(own.mean(axis=1), native),
        "sound": checks.sound,
        "wrong": "; ".join(checks.wrong),
        "wrong_hands": len(checks.wrong_chirality),
        "worst_bond_A": checks.worst_bond_A,
        "worst_angle_deg": checks.worst_angle_deg,
        "closest_A": checks.closest_A,
        "status": checks.status,
    }


def _curves(ends: StrandEnds) -> dict[str, Array]:
    """The same ends joined by a chord, an equal-length cubic and the free rod."""
    s = loop_arc_positions(ends.n)
    chord = ends.end_origin_A - ends.start_origin_A
    cubic = equal_length_hermite(
        ends.start_origin_A, ends.start_frame[:, 2], ends.end_origin_A, ends.end_frame[:, 2],
        ends.length_A, 1001,
    )  # fmt: skip
    clamping = Clamping.from_frames(
        ends.start_origin_A, ends.start_frame, ends.end_origin_A, ends.end_frame, ends.length_A,
        free_spin=True,
    )  # fmt: skip
    rod = solve(clamping)
    return {
        "chord": ends.start_origin_A + s[:, None] * chord,
        "cubic": cubic[np.round(1000 * s).astype(int)],
        "free_rod": ends.to_file(rod.centerline(s)),
    }
