"""The command line. Heavy modules are imported inside the commands that need them."""

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from loopelastica.studies.bench.commands import bench

if TYPE_CHECKING:
    from loopelastica._arrays import Array
    from loopelastica.atoms.write import LoopAtoms
    from loopelastica.folding.fold import LoopFold
    from loopelastica.molecule.nucleotides import Structure

app = typer.Typer(
    help="Folds nucleic-acid hairpin loops as elastic rods clamped to their stems.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

app.add_typer(bench, name="bench")

_Files = Annotated[
    list[Path], typer.Argument(help="PDB or mmCIF files, gzipped or not.", show_default=False)
]
_Irregular = Annotated[
    bool, typer.Option("--irregular", help="Fold loops on stems that are no A or B helix too.")
]
_Pairs = Annotated[
    list[str] | None,
    typer.Option("--pair", help="A pair known from other data, such as A.12-A.25; repeatable."),
]
_Brackets = Annotated[
    str | None,
    typer.Option(
        "--dot-bracket",
        help="Secondary structure in place of the pairs of the coordinates, all nucleotides of the"
        " file in their order.",
    ),
]
_Loops = Annotated[
    list[str] | None,
    typer.Option(
        "--loop",
        help="Only this loop, by its first and last nucleotide, such as A.13-24; repeatable. It may"
        " be absent from the file, then the numbers tell how many nucleotides it has.",
    ),
]
_Jobs = Annotated[
    int | None,
    typer.Option(help="Processes of a local dask cluster (extra `scale`); resumable.", min=1),
]
_Scheduler = Annotated[
    str | None, typer.Option(help="Address of a running dask scheduler, tcp://…; resumable.")
]


_Contact = Annotated[
    str | None,
    typer.Option(help="With atoms, seek a 'sheared' or 'watson-crick' pair of the loop's ends."),
]


def _version(wanted: bool) -> None:
    if wanted:
        from loopelastica._version import __version__

        typer.echo(f"loopelastica {__version__}")
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    # what the package has to say while it works
    logger = logging.getLogger("loopelastica")
    logger.setLevel(logging.INFO)
    logger.handlers = [logging.StreamHandler()]


@app.command()
def fold(
    files: _Files,
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")] = Path(
        "loopelastica-out"
    ),
    darboux: Annotated[
        bool,
        typer.Option(
            "--darboux/--free-spin",
            help="Clamp the direction to the helix axis too, or let the end turn freely.",
        ),
    ] = False,
    torsion_ratio: Annotated[
        float, typer.Option(help="K3/K0 of the backbone; matters with --darboux only.")
    ] = 1.0,
    length_per_nucleotide: Annotated[
        float | None,
        typer.Option(help="Line length per nucleotide in Å; default 6.0 (RNA), 6.3 (DNA)."),
    ] = None,
    stem_extend_5: Annotated[
        int | None,
        typer.Option(help="Nucleotides that continue the 5' strand; default by length.", min=0),
    ] = None,
    stem_extend_3: Annotated[
        int | None,
        typer.Option(help="Nucleotides that continue the 3' strand; default by length.", min=0),
    ] = None,
    taper: Annotated[
        float | None,
        typer.Option(
            help="Radius lost per nucleotide on the 3' strand; default 0.2 (RNA), 0 (DNA)."
        ),
    ] = None,
    persistence_length: Annotated[
        float, typer.Option(help="Persistence length in Å that turns E/K0 into kT.")
    ] = 10.0,
    energy_max: Annotated[
        float | None,
        typer.Option(help="List shapes up to this energy, in K0 per loop length."),
    ] = None,
    candidates: Annotated[int, typer.Option(help="Shapes kept per loop.", min=1)] = 10,
    all_models: Annotated[
        bool, typer.Option("--all-models/--first-model", help="Fold every model of the file.")
    ] = True,
    irregular: _Irregular = False,
    pair: _Pairs = None,
    dot_bracket: _Brackets = None,
    loop: _Loops = None,
    plot: Annotated[bool, typer.Option(help="Draw plot.png.")] = True,
    whole: Annotated[
        bool | None,
        typer.Option(
            "--whole/--no-whole",
            help="Write whole.pdb, the structure with the trace in place; by default up to"
            " 20,000 atoms.",
            show_default=False,
        ),
    ] = None,
    jobs: _Jobs = None,
    scheduler: _Scheduler = None,
    atoms: Annotated[
        bool, typer.Option("--atoms", help="Build the loop's atoms on every candidate's line.")
    ] = False,
    contact: _Contact = None,
) -> None:
    """Fold every hairpin loop of the files; write tables, traces and a picture per hairpin.

    With --jobs or --scheduler for thousands of files: candidates.csv grows as results come, and the
    same command resumes a run that was stopped.
    """
    from tqdm import tqdm

    from loopelastica.errors import LoopelasticaError
    from loopelastica.folding.fold import checked_parameters, fold_hairpins
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import read_structure
    from loopelastica.report.folder import Folders, write_fold
    from loopelastica.report.listing import remarks
    from loopelastica.report.pdb import WHOLE_ATOMS, WholeStructure, one_letter_chains
    from loopelastica.report.tables import console, fold_table

    options: dict[str, Any] = {
        "free_spin": not darboux,
        "torsion_ratio": torsion_ratio,
        "length_per_nucleotide_A": length_per_nucleotide,
        "stem_extend_5": stem_extend_5,
        "stem_extend_3": stem_extend_3,
        "taper": taper,
        "persistence_length_A": persistence_length,
        "energy_max": energy_max,
        "max_candidates": candidates,
        "all_models": all_models,
        "irregular": irregular,
        "pair": pair or (),
        "dot_bracket": dot_bracket,
        "loop": loop or (),
    }
    if jobs is not None or scheduler is not None:
        if atoms:
            raise typer.BadParameter("--atoms goes without --jobs and --scheduler")
        _fold_many(files, out, options, plot, jobs or 1, scheduler)
        return
    folders = Folders(out)
    notes: list[str] = []
    results: list[tuple[str, LoopFold | str, Path | None]] = []
    without_atoms: list[str] = []
    for file in tqdm(files, disable=len(files) < 2, unit="file", leave=False):
        try:
            structure = read_structure(file)
            found = find_hairpins(
                structure, pair=pair or (), dot_bracket=dot_bracket, loop=loop or ()
            )
            notes += [f"{file.name}: {sentence}" for sentence in remarks(structure, found)]
            loops = fold_hairpins(structure, found, checked_parameters(**options))
            small = len(structure.universe.atoms) <= WHOLE_ATOMS
            full = (
                WholeStructure(structure) if loops and (small if whole is None else whole) else None
            )
            chains = one_letter_chains(structure.nucleotides.chain.tolist())
            notes += [
                f"{file.name}: chain {chain} is {letter} in the PDB files that are written"
                for chain, letter in chains.items()
                if chain != letter
            ]
            if not loops:
                results.append((file.name, f"{file}: no hairpin loop found; nothing to fold", None))
            for folded in loops:
                folder = None
                if folded.failure is None:
                    folder = folders.claim(file, folded)
                    built = None
                    if atoms:
                        try:
                            built = _atoms(structure, folded, structure.positions(0), contact)
                        except LoopelasticaError as error:
                            without_atoms.append(f"{file.name}: {error}")
                    write_fold(folder, file, folded, structure, plot, full, built)
                notes += [f"{file.name}: {sentence}" for sentence in folded.remarks]
                results.append((file.name, folded, folder))
        except LoopelasticaError as error:
            results.append((file.name, str(error), None))
        except ValueError as error:
            # an option out of range concerns every file
            raise typer.BadParameter(str(error)) from None
        except OSError as error:
            results.append((file.name, f"{error.filename or file}: {error.strerror}", None))
    console().print(fold_table(results))
    for sentence in notes:
        typer.echo(f"note: {sentence}")
    failures = [
        result if isinstance(result, str) else f"{name}: {result.failure}"
        for name, result, _ in results
        if isinstance(result, str) or result.failure
    ] + without_atoms
    for sentence in failures:
        typer.echo(sentence, err=True)
    for name, result, _ in results:
        for sentence in () if isinstance(result, str) else result.model_failures:
            typer.echo(f"{name}: {sentence}", err=True)
    if failures:
        raise typer.Exit(1)


def _fold_many(
    files: list[Path],
    out: Path,
    options: dict[str, Any],
    plot: bool,
    jobs: int,
    scheduler: str | None,
) -> None:
    from loopelastica.batch.folds import FOLDS
    from loopelastica.batch.run import run, tasks_of
    from loopelastica.errors import MissingDependencyError
    from loopelastica.folding.fold import checked_parameters

    try:
        tasks = tasks_of(files, {**checked_parameters(**options), "plot": plot}, out)
        done = run(FOLDS, tasks, out, jobs, scheduler, progress=True)
    except (ValueError, MissingDependencyError) as error:
        raise typer.BadParameter(str(error)) from None
    typer.echo(
        f"{done.n_files} files ({done.n_resumed} were done before), {done.n_rows} candidates in"
        f" {done.table}"
    )
    _tell_failures(done.failures, out)


def _tell_failures(failures: tuple[str, ...], out: Path) -> None:
    """Print what failed, up to a screenful; exit status 1 if anything did."""
    shown = 20
    for sentence in failures[:shown]:
        typer.echo(sentence, err=True)
    if len(failures) > shown:
        typer.echo(f"{len(failures) - shown} more in {out / 'failures.csv'}", err=True)
    if failures:
        raise typer.Exit(1)


@app.command()
def build(
    sequence: Annotated[
        str,
        typer.Argument(help='Stem and loop, such as "GGCAC(UUCG)GUGCC".', show_default=False),
    ],
    is_dna: Annotated[
        bool, typer.Option("--dna/--rna", help="B-DNA or A-RNA stem.", show_default=False)
    ],
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")] = Path(
        "loopelastica-out"
    ),
    candidates: Annotated[int, typer.Option(help="Shapes kept.", min=1)] = 10,
    plot: Annotated[bool, typer.Option(help="Draw plot.png.")] = True,
    contact: _Contact = None,
) -> None:
    """Build a hairpin from its sequence alone: ideal stem, folded loop, atoms."""
    from loopelastica.atoms.sequence import fold_sequence
    from loopelastica.report.folder import Folders, write_fold
    from loopelastica.report.tables import console, fold_table

    try:
        structure, loop, positions = fold_sequence(sequence, is_dna, max_candidates=candidates)
        if loop.failure is not None:
            typer.echo(loop.failure, err=True)
            raise typer.Exit(1)
        built = _atoms(structure, loop, positions, contact)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    name = "".join(letter for letter in sequence.upper() if letter.isalpha())
    folder = Folders(out).claim(Path(name), loop)
    write_fold(folder, sequence, loop, structure, plot, atoms=built)
    console().print(fold_table([(name, loop, folder)]))


def _atoms(
    structure: "Structure", loop: "LoopFold", positions: "Array", contact: str | None
) -> "LoopAtoms":
    """Atoms of all candidates, with a progress bar."""
    from tqdm import tqdm

    from loopelastica.atoms.model import build_atoms
    from loopelastica.atoms.write import LoopAtoms

    with tqdm(total=len(loop.candidates), unit="model", leave=False) as bar:
        models = build_atoms(
            structure,
            loop,
            positions=positions,
            contact=contact,
            progress=lambda done, total: bar.update(),
        )
    return LoopAtoms(structure, loop, tuple(models), positions)


@app.command()
def evaluate(
    folder: Annotated[
        Path, typer.Argument(help="Folder of PDB and mmCIF files.", show_default=False)
    ],
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")] = Path(
        "loopelastica-evaluation"
    ),
    jobs: _Jobs = None,
    scheduler: _Scheduler = None,
) -> None:
    """Compare folds and simple curves with the loops of many files; write a scoreboard.

    The same command resumes a run that was stopped.
    """
    from loopelastica.errors import MissingDependencyError
    from loopelastica.studies.evaluation.scoreboard import evaluate as evaluate_folder

    try:
        done = evaluate_folder(folder, out, jobs or 1, scheduler, progress=True)
    except (ValueError, MissingDependencyError) as error:
        raise typer.BadParameter(str(error)) from None
    typer.echo(f"{done.n_files} files, {done.n_rows} loops: {out / 'scoreboard.md'}")
    _tell_failures(done.failures, out)


@app.command()
def scan(
    file: Annotated[Path, typer.Argument(help="PDB or mmCIF file.", show_default=False)],
    extend_5: Annotated[int, typer.Option(help="Most nucleotides on the 5' strand.", min=0)] = 2,
    extend_3: Annotated[int, typer.Option(help="Most nucleotides on the 3' strand.", min=0)] = 3,
    taper: Annotated[
        list[float] | None, typer.Option(help="Tapers of the 3' strand; default 0 and 0.2.")
    ] = None,
    irregular: _Irregular = False,
    pair: _Pairs = None,
    dot_bracket: _Brackets = None,
    loop: _Loops = None,
    shown: Annotated[int, typer.Option(help="Shapes shown per loop.", min=1)] = 20,
) -> None:
    """Solve every clamp that the stem allows; rank all shapes by deformation energy."""
    from loopelastica.errors import LoopelasticaError
    from loopelastica.folding.scan import scan as scan_file
    from loopelastica.report.tables import console, scan_table

    try:
        scans = scan_file(
            file,
            extend_5_max=extend_5,
            extend_3_max=extend_3,
            tapers=taper or (0.0, 0.2),
            irregular=irregular,
            pair=pair or (),
            dot_bracket=dot_bracket,
            loop=loop or (),
        )
    except LoopelasticaError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(1) from None
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    for scanned in scans:
        if scanned.failure:
            typer.echo(f"{file}: {scanned.failure}", err=True)
        else:
            console().print(scan_table(scanned, shown))
    if not scans:
        typer.echo(f"{file}: no hairpin loop found", err=True)
    if not scans or any(scanned.failure for scanned in scans):
        raise typer.Exit(1)


@app.command()
def hairpins(
    file: Annotated[Path, typer.Argument(help="PDB or mmCIF file.", show_default=False)],
    pair: _Pairs = None,
    dot_bracket: _Brackets = None,
    loop: _Loops = None,
    json_file: Annotated[
        Path | None, typer.Option("-o", "--json", help="Write it all to this file as JSON.")
    ] = None,
) -> None:
    """List the hairpin loops of a file, and its secondary structure in dot-bracket notation."""
    from loopelastica.errors import LoopelasticaError
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import read_structure
    from loopelastica.report.folder import write_json
    from loopelastica.report.listing import listing, remarks
    from loopelastica.report.tables import console, hairpins_table

    try:
        structure = read_structure(file)
        found = find_hairpins(structure, pair=pair or (), dot_bracket=dot_bracket, loop=loop or ())
        content = listing(structure, found)
        if json_file is not None:
            write_json(json_file, content)
    except LoopelasticaError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(1) from None
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    except OSError as error:
        typer.echo(f"{error.filename or json_file}: {error.strerror}", err=True)
        raise typer.Exit(1) from None
    if found:
        console().print(hairpins_table(content["hairpins"]))
    for chain in content["chains"]:
        typer.echo(f">{chain['chain'] or '_'} {chain['first']}-{chain['last']}")
        typer.echo(chain["sequence"])
        typer.echo(chain["dot_bracket"])
    for sentence in remarks(structure, found):
        typer.echo(f"note: {sentence}")
    for hairpin in content["hairpins"]:
        if hairpin["refusal"]:
            typer.echo(f"note: {hairpin['refusal']}")
    if not found:
        typer.echo(f"{file}: no hairpin loop found", err=True)
        raise typer.Exit(1)


@app.command()
def solve(
    clamping: Annotated[
        str,
        typer.Option(
            "--clamping", help='The six clamping parameters, e.g. "-0.4 -0.1 0.5 4.8 1.4 2.2".'
        ),
    ],
    torsion_ratio: Annotated[float, typer.Option(help="K30 = K3/K0.")] = 1.0,
    free_spin: Annotated[
        bool, typer.Option("--free-spin", help="Let the end turn about its tangent.")
    ] = False,
    energy_max: Annotated[
        float | None, typer.Option(help="List equilibria up to this energy, in K0/L.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Solve a dimensionless rod: its equilibria for a clamping (η1 η2 η3 ψ θ φ), angles in rad."""
    from loopelastica.rod.clamping import Clamping
    from loopelastica.rod.equilibria import equilibria

    try:
        values = [float(v) for v in clamping.replace(",", " ").split()]
        target = Clamping.from_parameters(values, free_spin)
        rods = equilibria(target, torsion_ratio, energy_max)
    except ValueError as error:
        typer.echo(f"--clamping {clamping!r}: {error}", err=True)
        raise typer.Exit(1) from None
    if as_json:
        import json

        found = {
            "energy_max": rods.energy_max,
            "unseen": rods.unseen,
            "equilibria": [rod.to_dict() for rod in rods],
        }
        typer.echo(json.dumps(found, indent=1, allow_nan=False))
    elif rods:
        from loopelastica.report.tables import console, equilibria_table

        console().print(equilibria_table(rods))
    if not rods:
        typer.echo(
            f"--clamping {clamping!r}: no equilibrium found in {rods.starts} starts", err=True
        )
        raise typer.Exit(1)


if __name__ == "__main__":
    app()
