"""``loopelastica hairpins`` and ``scan``: what a structure holds, and what its stems allow."""

from pathlib import Path
from typing import Annotated

import typer

from loopelastica.cli import options as o
from loopelastica.cli.program import tell


def hairpins(
    file: o.File,
    pair: o.Pairs = None,
    dot_bracket: o.Brackets = None,
    loop: o.Loops = None,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    json_file: Annotated[
        Path | None, typer.Option("-o", "--json", help="Write it all to this file as JSON.")
    ] = None,
) -> None:
    """List the hairpin loops of a file, and its secondary structure in dot-bracket notation."""
    from loopelastica._files import write_json
    from loopelastica.folding.options import LoopOptions
    from loopelastica.molecule.hairpins import find_hairpins
    from loopelastica.molecule.nucleotides import Limits, read_structure
    from loopelastica.report.listing import listing, remarks
    from loopelastica.report.tables import console, hairpins_table

    with o.usage():
        limits = Limits(**o.limits(max_size, max_atoms))
        selection = LoopOptions(pair=pair or (), dot_bracket=dot_bracket, loop=loop or ()).selection
        structure = read_structure(file, limits)
        found = find_hairpins(structure, **selection)
    content = listing(structure, found)
    if json_file is not None:
        write_json(json_file, content)
    if found:
        console().print(hairpins_table(content["hairpins"]))
    for chain in content["chains"]:
        tell(f">{chain['chain'] or '_'} {chain['first']}-{chain['last']}")
        typer.echo(chain["sequence"])
        typer.echo(chain["dot_bracket"])
    refused = [hairpin["refusal"] for hairpin in content["hairpins"] if hairpin["refusal"]]
    o.note([*remarks(structure, found), *refused])
    if not found:
        o.fail([f"{file}: no hairpin loop found"])


def scan(
    file: o.File,
    extend_5: Annotated[int, typer.Option(help="Most nucleotides on the 5' strand.", min=0)] = 2,
    extend_3: Annotated[int, typer.Option(help="Most nucleotides on the 3' strand.", min=0)] = 3,
    taper: Annotated[
        list[float] | None, typer.Option(help="Tapers of the 3' strand; default 0 and 0.2.")
    ] = None,
    irregular: o.Irregular = False,
    pair: o.Pairs = None,
    dot_bracket: o.Brackets = None,
    loop: o.Loops = None,
    max_size: o.MaxSize = None,
    max_atoms: o.MaxAtoms = None,
    shown: Annotated[int, typer.Option(help="Shapes shown per loop.", min=1)] = 20,
) -> None:
    """Solve every clamp that the stem allows; rank all shapes: by energy, touching last."""
    from loopelastica.folding.scan import scan as scan_file
    from loopelastica.report.tables import console, scan_table

    with o.usage():
        scans = scan_file(
            file,
            extend_5_max=extend_5,
            extend_3_max=extend_3,
            tapers=taper or (0.0, 0.2),
            irregular=irregular,
            pair=pair or (),
            dot_bracket=dot_bracket,
            loop=loop or (),
            **o.limits(max_size, max_atoms),
        )
    for scanned in scans:
        if not scanned.failure:
            console().print(scan_table(scanned, shown))
    failures = [f"{file}: {scanned.failure}" for scanned in scans if scanned.failure]
    o.fail(failures if scans else [f"{file}: no hairpin loop found"])
