"""The command line. Heavy modules are imported inside the commands that need them."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from loopelastica.atoms.write import LoopAtoms
    from loopelastica.folding import LoopFold
    from loopelastica.molecule.nucleotides import Structure
    from loopelastica.rod.clamping import Array

app = typer.Typer(
    help="Folds nucleic-acid hairpin loops as elastic rods clamped to their stems.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

bench = typer.Typer(help="Measure the solvers; write tables and pictures.", no_args_is_help=True)
app.add_typer(bench, name="bench")

_Files = Annotated[
    list[Path], typer.Argument(help="PDB or mmCIF files, gzipped or not.", show_default=False)
]


_Contact = Annotated[
    str | None,
    typer.Option(help="With atoms, seek a 'sheared' or 'watson-crick' pair of the loop's ends."),
]


def _version(wanted: bool) -> None:
    if wanted:
        from loopelastica import __version__

        typer.echo(f"loopelastica {__version__}")
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


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
    plot: Annotated[bool, typer.Option(help="Draw plot.png.")] = True,
    atoms: Annotated[
        bool, typer.Option("--atoms", help="Build the loop's atoms on every candidate's line.")
    ] = False,
    contact: _Contact = None,
) -> None:
    """Fold every hairpin loop of the files; write tables, traces and a picture per hairpin."""
    from tqdm import tqdm

    from loopelastica.errors import LoopelasticaError
    from loopelastica.folding import fold as fold_file
    from loopelastica.molecule.nucleotides import read_structure
    from loopelastica.output import Folders, write_fold

    folders = Folders(out)
    results: list[tuple[str, LoopFold | str, Path | None]] = []
    without_atoms: list[str] = []
    for file in tqdm(files, disable=len(files) < 2, unit="file", leave=False):
        try:
            structure = read_structure(file)
            loops = fold_file(
                structure,
                free_spin=not darboux,
                torsion_ratio=torsion_ratio,
                length_per_nucleotide_A=length_per_nucleotide,
                persistence_length_A=persistence_length,
                energy_max=energy_max,
                max_candidates=candidates,
                all_models=all_models,
            )
            if not loops:
                results.append((file.name, f"{file}: no hairpin loop found; nothing to fold", None))
            for loop in loops:
                folder = None
                if loop.failure is None:
                    folder = folders.claim(file, loop)
                    built = None
                    if atoms:
                        try:
                            built = _atoms(structure, loop, structure.positions(0), contact)
                        except LoopelasticaError as error:
                            without_atoms.append(f"{file.name}: {error}")
                    write_fold(folder, file, loop, structure.nucleotides, plot, built)
                results.append((file.name, loop, folder))
        except LoopelasticaError as error:
            results.append((file.name, str(error), None))
        except ValueError as error:
            # an option out of range concerns every file
            raise typer.BadParameter(str(error)) from None
        except OSError as error:
            results.append((file.name, f"{error.filename or file}: {error.strerror}", None))
    _console().print(_fold_table(results))
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
    from loopelastica.output import Folders, write_fold

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
    write_fold(folder, sequence, loop, structure.nucleotides, plot, built)
    _console().print(_fold_table([(name, loop, folder)]))


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


def _console() -> "Console":
    from rich.console import Console

    console = Console()
    # a file or a pipe has no width: leave the numbers whole
    return console if console.is_terminal else Console(width=150)


def _fold_table(results: "list[tuple[str, LoopFold | str, Path | None]]") -> "Table":
    from rich.table import Table

    from loopelastica.output import rmsd_summary

    table = Table(
        title="Loops folded, least energy first. Energy is no confidence; RMSD without"
        " superposition, where the file has the loop.",
        title_justify="left",
    )
    for name in ("file", "closing pair", "sequence"):
        table.add_column(name, overflow="fold")
    for name in ("rank", "E/K0 (1/Å)", "E (kT)", "RMSD (Å)", "models (Å)", "residual"):
        table.add_column(name, justify="right")
    table.add_column("folder", overflow="fold")
    for name, result, folder in results:
        if isinstance(result, str):
            table.add_row(name, "not folded: see below")
            continue
        pair = "–".join(result.hairpin.closing_pair)
        if result.failure:
            table.add_row(name, pair, result.hairpin.sequence, "not folded: see below")
        for c in result.candidates:
            mean, deviation, count = rmsd_summary(c)
            models = "" if mean is None or count < 2 else f"{mean:.2f} ± {deviation:.2f} ({count})"
            first = c.rank == 1
            table.add_row(
                name if first else "",
                pair if first else "",
                result.hairpin.sequence if first else "",
                str(c.rank),
                f"{c.energy_per_A:.4f}",
                f"{c.energy_kT:.2f}",
                "" if c.rmsd_A is None else f"{c.rmsd_A:.2f}",
                models,
                f"{c.residual:.0e}",
                str(folder) if first else "",
            )
        table.add_section()
    return table


@app.command()
def hairpins(
    file: Annotated[Path, typer.Argument(help="PDB or mmCIF file.", show_default=False)],
) -> None:
    """List the hairpin loops of a file."""
    from rich.table import Table

    from loopelastica.errors import LoopelasticaError
    from loopelastica.molecule.hairpins import find_hairpins

    try:
        found = find_hairpins(file)
    except LoopelasticaError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(1) from None
    if not found:
        typer.echo(f"{file}: no hairpin loop found", err=True)
        raise typer.Exit(1)
    table = Table()
    for name in ("chain", "closing pair", "sequence", "loop", "kind", "stem pairs", "contacts"):
        table.add_column(name)
    for hairpin in found:
        table.add_row(
            hairpin.chain or "_",
            "–".join(hairpin.closing_pair),
            hairpin.sequence,
            f"{len(hairpin.loop)} nt",
            "DNA" if hairpin.is_dna else "RNA",
            str(len(hairpin.stem_5)),
            ", ".join("–".join(pair) for pair in hairpin.contacts),
        )
    _console().print(table)


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
        from rich.table import Table

        table = Table(title=f"unseen: {rods.unseen:.2f} of further starts", title_justify="left")
        for name in ("energy", "F (start frame)", "M (start frame)", "twist", "residual"):
            table.add_column(name, justify="right", no_wrap=True)
        for rod in rods:
            table.add_row(
                f"{rod.energy:.6g}",
                " ".join(f"{v:9.4g}" for v in rod.loads[:3]),
                " ".join(f"{v:9.4g}" for v in rod.loads[3:]),
                f"{rod.twist:.4f}",
                f"{rod.residual:.0e}",
            )
        _console().print(table)
    if not rods:
        typer.echo(
            f"--clamping {clamping!r}: no equilibrium found in {rods.starts} starts", err=True
        )
        raise typer.Exit(1)


@bench.command("paper")
def bench_paper(
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")] = Path(
        "loopelastica-bench/paper"
    ),
    full: Annotated[bool, typer.Option("--full", help="Every rod of the paper's sets.")] = False,
    sample: Annotated[int, typer.Option(help="Rods per cell otherwise.", min=1)] = 400,
) -> None:
    """Rerun the studies of Figs. 3, 4 and 5 of the 2018 paper with its printed method."""
    from loopelastica.bench.paper import run

    run(out, full=full, sample=sample, progress=True)
    typer.echo(f"written to {out}")


@bench.command("atoms")
def bench_atoms(
    folder: Annotated[Path, typer.Argument(help="Folder of structure files.", show_default=False)],
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")] = Path(
        "loopelastica-bench/atoms"
    ),
    sample: Annotated[
        int | None, typer.Option(help="Only so many files, evenly spread.", min=1)
    ] = None,
) -> None:
    """Build the first candidate's atoms for every simple loop of a folder; judge the models."""
    from loopelastica.bench.atoms import run

    typer.echo(run(folder, out, sample=sample, progress=True))
    typer.echo(f"written to {out}")


@bench.command("stability")
def bench_stability(
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder for the results.")] = Path(
        "loopelastica-bench/stability"
    ),
    full: Annotated[bool, typer.Option("--full", help="Large samples; some minutes.")] = False,
    seed: Annotated[int, typer.Option(help="Seed of the random poses.")] = 2026,
) -> None:
    """Solve stiff, extreme and degenerate clampings; judge each result independently."""
    from loopelastica.bench.stability import run

    run(out, full=full, seed=seed, progress=True)
    typer.echo(f"written to {out}")


if __name__ == "__main__":
    app()
