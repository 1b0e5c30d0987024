"""What a nanostructure writes: files of one stem in a folder, all of them or none.

``<stem>.json`` is the manifest. A design with a strand that cannot be laid gets that file alone: a
configuration without some of its nucleotides would be of another structure.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from loopelastica._checks import file_name, one_of
from loopelastica._files import PROGRAM, is_whole, whole_folder, write_json, write_text
from loopelastica._names import printable, safe_stem
from loopelastica._version import __version__
from loopelastica.errors import StructureError
from loopelastica.nanostructures.nanostructure import Nanostructure
from loopelastica.nanostructures.oxdna.checks import closest_centres
from loopelastica.nanostructures.oxdna.energies import bonds
from loopelastica.nanostructures.oxdna.files import (
    CONFIGURATIONS,
    TOPOLOGY,
    line_order,
    oxdna_texts,
    refuse_input,
    write_oxdna,
)
from loopelastica.nanostructures.oxdna.model import BOND_LONGEST, BOND_SHORTEST, UNIT_NM
from loopelastica.nanostructures.oxdna.topology import Form
from loopelastica.report.coarse_trace import (
    mmcif_text,
    oxview_text,
    pdb_text,
    pymol_text,
    trace,
)

CONFIGURATION: Final = ".dat"
_TRACES: Final = (".cif", ".mmcif", ".pdb")
_OXVIEW: Final = ".oxview"
_KEY: Final = ("version", "sha256", "parameters", "form")
"""Entries of the manifest that determine all else."""


def write_nanostructure(name: str | Path, found: Nanostructure, form: Form = "old") -> Path:
    """Write a nanostructure into the files that a name stands for, or into a folder.

    Parameters
    ----------
    name : str or Path
        As for :meth:`Nanostructure.write`.
    found : Nanostructure
        What was laid.
    form : {"old", "new"}, optional
        Of the topology.

    Returns
    -------
    Path
        What was written.

    Raises
    ------
    ValueError
        If the name or the form is none.
    StructureError
        If a strand was refused, or the format does not hold it.
    OutputError
        If it cannot be written.
    """
    path = Path(file_name("path", name))
    one_of("old", "new")("form", form)
    refuse_incomplete(found)
    suffix = path.suffix.lower()
    if suffix in (TOPOLOGY, *CONFIGURATIONS):
        topology = path if suffix == TOPOLOGY else path.with_suffix(TOPOLOGY)
        configuration = path if suffix in CONFIGURATIONS else path.with_suffix(CONFIGURATION)
        write_oxdna(found.system, topology, configuration, form=form, files=found.files)
    elif suffix == _OXVIEW:
        write_text(path, oxview_text(found, _lines(found, form)))
    elif suffix in _TRACES:
        structure = trace(found)
        text = pdb_text(structure) if suffix == ".pdb" else mmcif_text(structure)
        if text is None:
            raise StructureError(
                f"{path}: the PDB format does not hold so many strands or nucleotides; name it"
                " *.cif"
            )
        write_text(path, text)
    else:
        write_folder(path, safe_stem(found.paths[0]), found, form)
    return path


def refuse_incomplete(found: Nanostructure) -> None:
    """StructureError where a strand was refused."""
    if not found.refused:
        return
    first, *more = found.refused
    rest = f"; {len(more)} more are refused too" if more else ""
    raise StructureError(
        f"{found.name}: nothing is written, for a strand cannot be laid: {first.reason}{rest}"
    )


def write_folder(
    folder: Path,
    stem: str,
    found: Nanostructure,
    form: Form = "old",
    inputs: Iterable[Path] = (),
) -> dict[str, Any]:
    """Write the files of a nanostructure beside those of others.

    Parameters
    ----------
    folder : Path
        Of the results.
    stem : str
        What the names of the files begin with.
    found : Nanostructure
        What was laid. Where a strand was refused, the JSON file is all.
    form : {"old", "new"}, optional
        Of the topology.
    inputs : iterable of Path
        Files beside its own that may not be written over.

    Returns
    -------
    dict
        The key of the result, for :func:`is_there`.

    Raises
    ------
    FileExistsError
        If something is in the way, an input or what others have written. Nothing is changed.
    """
    texts = {} if found.refused else _texts(stem, found, form)
    manifest = f"{stem}.json"
    names = sorted([manifest, *texts])
    for name in names:
        refuse_input(folder / name, (*found.paths, *inputs))
    content = {**record_of(found, form), "files": names}
    with whole_folder(folder, manifest, shared=True) as part:
        for name, text in texts.items():
            write_text(part / name, text)
        write_json(part / manifest, content)
    return {name: content[name] for name in _KEY}


def is_there(folder: Path, stem: str, key: Mapping[str, Any]) -> bool:
    """Whether a folder holds the whole result of a design and of one set of options.

    Parameters
    ----------
    folder, stem
        As for :func:`write_folder`, which has returned `key`.

    Returns
    -------
    bool
    """
    return is_whole(folder / f"{stem}.json", key)


def _texts(stem: str, found: Nanostructure, form: Form) -> dict[str, str]:
    """Contents of the files by their names."""
    topology, configuration = oxdna_texts(found.system, form, found.files)
    texts = {f"{stem}{TOPOLOGY}": topology, f"{stem}{CONFIGURATION}": configuration}
    for k, sample in enumerate(found.samples, start=1):
        texts[f"{stem}_sample{k}{CONFIGURATION}"] = oxdna_texts(sample.system, form, found.files)[1]
    structure = trace(found)
    texts[f"{stem}.cif"] = mmcif_text(structure)
    pdb = pdb_text(structure)
    if pdb is not None:
        texts[f"{stem}.pdb"] = pdb
    texts[f"{stem}.pml"] = pymol_text(found, f"{stem}.cif")
    if any(found.system.colour):
        texts[f"{stem}{_OXVIEW}"] = oxview_text(found, _lines(found, form))
    return texts


def _lines(found: Nanostructure, form: Form) -> NDArray[np.int64]:
    """Line of each nucleotide in the configuration, from 0."""
    return np.argsort(line_order(found.system, form, found.files))


def record_of(found: Nanostructure, form: Form) -> dict[str, Any]:
    """The content of <stem>.json, without its list of files.

    Parameters
    ----------
    found : Nanostructure
    form : {"old", "new"}

    Returns
    -------
    dict
        JSON-ready. Lengths in nm where their names say so, else in oxDNA's units.
    """
    system, line = found.system, _lines(found, form)
    strands = [
        {
            **found.row(strand),
            "lines": line[strand.nucleotides].tolist(),
            "conflicts": [conflict.sentence for conflict in strand.conflicts],
            "remark": strand.remark or None,
        }
        for strand in found.strands
    ]
    return {
        "program": PROGRAM,
        "version": __version__,
        "input": printable(Path(found.name).name),
        "inputs": [
            {"file": printable(path.name), "sha256": digest}
            for path, digest in zip(found.paths, found.sha256, strict=True)
        ],
        "sha256": list(found.sha256),
        # which files they are stands above
        "parameters": {k: v for k, v in found.options.to_dict().items() if k != "other"},
        "persistence_length_nm": found.persistence_length_nm,
        "form": form,
        "unit_nm": UNIT_NM,
        "nucleotides": len(system),
        "base_pairs": int((system.pair >= 0).sum()) // 2,
        "status": "refused" if found.refused else "written",
        "refused": [strand.reason for strand in found.refused],
        "strands": strands,
        "samples": [
            {"conflicts": [conflict.sentence for conflict in sample.conflicts]}
            for sample in found.samples
        ],
        "checks": checks_of(found),
        "notes": list(found.notes),
    }


def checks_of(found: Nanostructure) -> dict[str, Any]:
    """Whether a simulation can start from it, in oxDNA's units; not where a strand was refused.

    Parameters
    ----------
    found : Nanostructure

    Returns
    -------
    dict
        JSON-ready.
    """
    start, length = found.check(), bonds(found.system).length
    return {
        "sound": start.sound and not found.refused,
        "bond_window": [round(BOND_SHORTEST, 4), round(BOND_LONGEST, 4)],
        "bonds": [_rounded(length.min()), _rounded(length.max())] if len(length) else None,
        "bonds_outside": len(start.broken),
        "closest_centres": _rounded(closest_centres(found.system)),
        "centres_too_close": len(start.close),
        "axes_skewed": len(start.skewed),
    }


def _rounded(value: Any) -> float | None:
    return None if value is None else round(float(value), 6)
