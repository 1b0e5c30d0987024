"""The work of ``loopelastica evaluate`` on one file: every loop, by every method."""

import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._arrays import Array
from loopelastica.batch.journal import Record
from loopelastica.batch.run import Work
from loopelastica.batch.tasks import Task
from loopelastica.errors import StructureError
from loopelastica.folding.clamping import clamping_of
from loopelastica.folding.fold import fold_model
from loopelastica.folding.hypotheses import STRAIGHT, scene_of
from loopelastica.folding.options import FoldOptions
from loopelastica.folding.result import LoopFold
from loopelastica.folding.surroundings import SURROUNDED
from loopelastica.molecule.clamp_rule import StemClamp, plain_clamp
from loopelastica.molecule.ends import FittedStem, StemEnds, fit_stem
from loopelastica.molecule.hairpins import find_hairpins
from loopelastica.molecule.nucleotides import read_structure
from loopelastica.molecule.trace import loop_arc_positions, rmsd_A, to_file_coordinates
from loopelastica.rod.solve import solve
from loopelastica.studies.evaluation.curves import arc, chord, hermite, stem_axes

# nothing that is related to a loop is known of it, and no answer is left out
HONEST: dict[str, Any] = {"exclude_relatives": True, "max_candidates": 1000}
PLAIN: dict[str, Any] = {"stem_extend_5": 0, "stem_extend_3": 0, "taper": 0.0, "shapes": "rod"}
CURVES = {"chord": chord, "arc": arc, "hermite": hermite}
# clamps among which the constants are refitted: extensions of both strands, tapers of the 3' one
EXTENSIONS = tuple(product(range(3), range(4)))
TAPERS = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
# refined with elastic models of hairpins itself
NOT_EVIDENCE = ("2l5k",)
# of a file's hairpins; beyond, its loops sit in tertiary contacts and are shown as a set of its own
SMALL_FILE = 10

COLUMNS = (
    *("file", "loop", "set", "kind", "type", "family", "closing_pair", "closing_type"),
    *("sequence", "nucleotides", "stem_pairs", "contacts", "simple", "free_nucleotides"),
    *("stem_extend_5", "stem_extend_3", "taper", "stem_rms_A", "energy_per_A", "energy_EL"),
    *("touching", "stem_contact_A", "n_candidates", "rank_of_best", "shape", "shape_source"),
    *("expected_10_A", "expected_50_A", "expected_90_A", "inside"),
    *("rmsd_first_A", "rmsd_best5_A", "rmsd_best_A"),
    *("n_models", "models_first_A", "models_first_sd_A", "models_best5_A", "models_best_A"),
    *("rod_A", "surrounded_A", "plain_rod_A", "chord_A", "arc_A", "hermite_A"),
    *("plain_chord_A", "plain_arc_A", "plain_hermite_A"),
)


def evaluate_file(task: Task) -> Record:
    """Measure every loop of a file; rows for the scoreboard.

    Beside the columns of the table a row holds ``native`` (the loop in the axes of its stem, for
    mean loops) and ``grid`` (the RMSD at each of `TAPERS` × `EXTENSIONS`, for refits).
    """
    source = Path(task.source)
    options = FoldOptions(**task.options)
    structure = read_structure(source, options.limits)
    hairpins = find_hairpins(structure)
    rows, failures = [], []
    plain = FoldOptions(**task.options | PLAIN)
    scene = scene_of(structure, hairpins, options)
    models = list(structure.models())
    for hairpin in hairpins:
        folds = [fold_model(structure.nucleotides, hairpin, x, options, scene) for x in models]
        first = folds[0]
        if first.failure is not None:
            failures.append(f"{source}: {first.failure}")
            continue
        if first.backbone_A is None:
            failures.append(f"{source}: {hairpin.name}: a loop atom is missing; not compared")
            continue
        plain_fold = fold_model(structure.nucleotides, hairpin, models[0], plain)
        stem = fit_stem(structure.nucleotides, hairpin, models[0])
        row = _about(source, first, len(hairpins)) | _by_rank(folds) | _by_shape(first)
        row |= _by_curves(first, plain_fold)
        native = np.asarray(first.backbone_A)[1:-1]
        middle, axes = stem_axes(stem.ends(plain_clamp(hairpin.is_dna)))
        row["native"] = ((native - middle) @ axes).tolist()
        row["grid"] = _grid(stem, native) if row["simple"] else None
        rows.append(row)
    return {"rows": rows, "failures": failures}


def motif(sequence: str) -> str:
    """Name of a loop by its sequence, closing pair included.

    >>> motif("GGAAAC"), motif("CUUCGG"), motif("CGAAG")
    ('GNRA', 'UNCG', 'triloop')
    """
    loop = sequence[1:-1].replace("T", "U")
    if len(loop) == 4 and loop[0] == "G" and loop[2] in "AG" and loop[3] == "A":
        return "GNRA"
    if len(loop) == 4 and loop[0] == "U" and loop[2:] == "CG":
        return "UNCG"
    names = {3: "triloop", 4: "other tetraloop", 5: "pentaloop", 6: "hexaloop", 7: "heptaloop"}
    return names.get(len(loop), "8 and more")


def _about(source: Path, fold: LoopFold, n_hairpins: int) -> dict[str, Any]:
    hairpin, ends = fold.hairpin, fold.ends
    assert ends is not None
    kind, sequence = ("DNA" if hairpin.is_dna else "RNA"), hairpin.sequence.replace("T", "U")
    name = motif(sequence) if kind == "RNA" else "other"
    evidence = not source.name.lower().startswith(NOT_EVIDENCE)
    best = fold.candidates[0]
    small = "small files" if n_hairpins <= SMALL_FILE else "large files"
    return {
        "file": str(source),
        "loop": hairpin.name,
        "set": "not evidence" if not evidence else "DNA" if kind == "DNA" else f"RNA, {small}",
        "kind": kind,
        "type": motif(sequence),
        # relatives share one: what is fitted on a loop is not judged on its family
        "family": f"{kind} {name if name in ('GNRA', 'UNCG') else sequence}",
        "closing_pair": hairpin.label,
        "closing_type": f"{sequence[0]}-{sequence[-1]}",
        "sequence": hairpin.sequence,
        "nucleotides": len(hairpin),
        "stem_pairs": hairpin.n_pairs,
        "contacts": len(hairpin.contacts),
        "simple": evidence and not hairpin.contacts and 3 <= len(hairpin) <= 9,
        "free_nucleotides": ends.n_free,
        **{n: v for n, v in ends.clamp.to_dict().items() if n != "length_per_nucleotide_A"},
        "stem_rms_A": ends.rms_A,
        "energy_per_A": best.energy_per_A,
        "energy_EL": best.line.energy,
        "touching": best.contacts.touching,
        "stem_contact_A": best.contacts.stem_A if math.isfinite(best.contacts.stem_A) else None,
        "n_candidates": len(fold.candidates),
    }


def _by_rank(folds: list[LoopFold]) -> dict[str, Any]:
    """RMSD of the first, the best of five and the best of all, model 1 and over all models."""
    table = []
    for fold in folds:
        values = [c.rmsd_A for c in fold.candidates if c.rmsd_A is not None]
        if values:
            table.append((values[0], min(values[:5]), min(values)))
    first = [c.rmsd_A for c in folds[0].candidates if c.rmsd_A is not None]
    all_models = np.array(table)
    mean = all_models.mean(axis=0).tolist()
    return {
        "rank_of_best": int(np.argmin(first)) + 1,
        "rmsd_first_A": first[0],
        "rmsd_best5_A": min(first[:5]),
        "rmsd_best_A": min(first),
        "n_models": len(table),
        "models_first_A": mean[0],
        "models_first_sd_A": float(all_models[:, 0].std(ddof=1)) if len(table) > 1 else None,
        "models_best5_A": mean[1],
        "models_best_A": mean[2],
    }


def _by_shape(fold: LoopFold) -> dict[str, Any]:
    """What the first answer is, its expected error, and whether it held; RMSD of the rods."""
    first = fold.candidates[0]
    low, middle, high = first.expected_rmsd_A.tolist()
    assert first.rmsd_A is not None
    rods = {
        name: next((c.rmsd_A for c in fold.candidates if c.shape == shape), None)
        for name, shape in (("rod_A", STRAIGHT), ("surrounded_A", SURROUNDED))
    }
    return {
        "shape": first.shape,
        "shape_source": shape_source(first.shape),
        "expected_10_A": low,
        "expected_50_A": middle,
        "expected_90_A": high,
        "inside": low <= first.rmsd_A <= high,
        **rods,
    }


def shape_source(shape: str) -> str:
    """Where a shape is from, without what it is made of in this case.

    >>> shape_source("motif GNRA, 83 loops"), shape_source("mean of 40 loops")
    ('motif GNRA', 'mean of its length')
    >>> shape_source("library 3d2v A.17-A.22 (UUCA)"), shape_source("straight rod")
    ('library', 'straight rod')
    """
    if shape.startswith("mean of "):
        return "mean of its length"
    return "library" if shape.startswith("library ") else shape.split(",")[0]


def _by_curves(fold: LoopFold, plain: LoopFold) -> dict[str, Any]:
    """RMSD of simple curves on the same ends, and on those of the closing pair."""
    assert fold.ends is not None
    assert fold.backbone_A is not None
    native = np.asarray(fold.backbone_A)[1:-1]
    row: dict[str, Any] = {
        f"{name}_A": rmsd_A(_trace(fold.ends, curve(fold.ends, _places(fold.ends))), native)
        for name, curve in CURVES.items()
    }
    row["plain_rod_A"] = plain.candidates[0].rmsd_A if plain.candidates else None
    for name, curve in CURVES.items():
        row[f"plain_{name}_A"] = (
            None if plain.ends is None else rmsd_A(curve(plain.ends, _places(plain.ends)), native)
        )
    return row


def _grid(stem: FittedStem, native: Array) -> list[list[float | None]]:
    """RMSD of the lowest rod at each taper and extension, taken back where none spans the ends."""
    length = plain_clamp(stem.hairpin.is_dna).length_per_nucleotide_A
    solved: dict[StemClamp, float] = {}
    table = []
    for taper in TAPERS:
        row: list[float | None] = []
        for extend_5, extend_3 in EXTENSIONS:
            # at least two nucleotides stay with the rod
            over = max(extend_5 + extend_3 - (len(native) - 2), 0)
            three = max(extend_3 - over, 0)
            five = extend_5 - max(over - extend_3, 0)
            try:
                ends = stem.feasible(StemClamp(five, three, taper, length))
            except StructureError:
                row.append(None)
                continue
            if ends.clamp not in solved:
                rod = solve(clamping_of(ends, free_spin=True))
                line = to_file_coordinates(
                    rod.centerline(_places(ends)),
                    ends.start_origin_A,
                    ends.start_frame,
                    ends.length_A,
                )
                solved[ends.clamp] = rmsd_A(_trace(ends, line), native)
            row.append(solved[ends.clamp])
        table.append(row)
    return table


def _places(ends: StemEnds) -> Array:
    return loop_arc_positions(ends.n_free)


def _trace(ends: StemEnds, free: Array) -> Array:
    return np.concatenate([ends.continued_5_A, free, ends.continued_3_A])


EVALUATION = Work("loops", evaluate_file, COLUMNS, lambda task, record: True)
