"""Records of the PDB format: points of a trace, and the whole structure with a loop replaced."""

from __future__ import annotations

import math
import string
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from loopelastica._files import write_text
from loopelastica._names import printable
from loopelastica._version import __version__
from loopelastica.folding.rank import Candidate
from loopelastica.folding.result import LoopFold
from loopelastica.molecule.nucleotides import Structure, is_pdb, pdb_records, quiet
from loopelastica.molecule.origin import Origin, origin_of

POINT = "CEN"
"""Atom name of the point of the line that stands for a nucleotide."""

WHOLE_ATOMS = 20_000
"""Most atoms of a structure that is written once more for each loop without a request: all loops of
a ribosome would make half a gigabyte."""

B_MAX_A2 = 999.0
"""Largest B factor that is written: what its column of the PDB format holds."""

# letters of a remark that fit into an 80-column record
_NOTE = 66
_ATOMS = ("ATOM  ", "HETATM")
_LEVEL = {"resnames": "residues", "icodes": "residues", "segids": "segments"}
_LETTERS = string.ascii_uppercase + string.ascii_lowercase + string.digits


def is_small(structure: Structure) -> bool:
    """Whether whole.pdb is written of it without a request."""
    return len(structure.universe.atoms) <= WHOLE_ATOMS


def pdb_name(text: str) -> str:
    r"""A name as a record of the PDB format can hold it: visible ASCII, all else as ``_``.

    >>> pdb_name("A\n B"), pdb_name("C1'")
    ('A__B', "C1'")
    """
    return "".join(c if "!" <= c <= "~" else "_" for c in text)


def one_letter_chains(chains: Iterable[str]) -> dict[str, str]:
    """A letter of the PDB format for each chain: its own where it has one, else the first free one.

    Chains beyond the 62nd share the letter Z.

    >>> one_letter_chains(["AA", "A", "", "AB"])
    {'AA': 'B', 'A': 'A', '': '', 'AB': 'C'}
    """
    chains = list(dict.fromkeys(chains))
    free = iter([letter for letter in _LETTERS if letter not in chains])
    return {
        chain: chain if len(chain) <= 1 and pdb_name(chain) == chain else next(free, "Z")
        for chain in chains
    }


def chain_letters(structure: Structure) -> dict[str, str]:
    """A letter of the PDB format for each chain of a structure, the same in all its files."""
    return one_letter_chains(_chains(structure.universe))


def renamed(structure: Structure) -> dict[str, str]:
    """The chains that the PDB format makes another letter, with that letter."""
    return {chain: a for chain, a in chain_letters(structure).items() if chain != a}


def cell_record(origin: Origin) -> list[str]:
    """The CRYST1 record of a unit cell; none where there is no cell.

    >>> cell_record(Origin((40.0, 50.0, 60.0, 90.0, 90.0, 90.0), "P 21 21 21"))
    ['CRYST1   40.000   50.000   60.000  90.00  90.00  90.00 P 21 21 21']
    """
    if origin.cell is None:
        return []
    lengths = "".join(f"{value:9.3f}" for value in origin.cell[:3])
    angles = "".join(f"{value:7.2f}" for value in origin.cell[3:])
    return [f"CRYST1{lengths}{angles} {origin.space_group or 'P 1'}"]


def renamed_records(letters: dict[str, str]) -> list[str]:
    """REMARK records for the chains that got another letter."""
    return [
        f"REMARK  99 CHAIN {printable(chain)} IS WRITTEN AS {letter}"
        for chain, letter in letters.items()
        if chain != letter
    ]


def b_factor(rmsd_A: float) -> float:
    """B factor (Å²) of an error: 8π²/3 of its square, up to what the PDB format holds.

    >>> f"{b_factor(2.0):.1f}"
    '105.3'
    """
    return min(8.0 * math.pi**2 / 3.0 * rmsd_A**2, B_MAX_A2)


def expected_notes(candidates: Iterable[Candidate]) -> list[str]:
    """Remarks on the shapes of candidates and the errors to expect of them, visible ASCII."""
    notes = ["THE B FACTOR IS 8 PI^2/3 OF THE EXPECTED ERROR SQUARED"]
    for one in candidates:
        low, middle, high = one.expected_rmsd_A
        shape = " ".join(pdb_name(word) for word in printable(one.shape).split())
        notes += [
            f"CANDIDATE {one.rank}: {shape}"[:_NOTE],
            f"  EXPECTED ERROR {middle:.1f} A (80 % BETWEEN {low:.1f} AND {high:.1f})",
        ]
    return notes


def expected_records(candidates: Iterable[Candidate]) -> list[str]:
    """The same as REMARK records."""
    return [f"REMARK  99 {note}" for note in expected_notes(candidates)]


def point_records(
    fold: LoopFold, structure: Structure, candidate: Candidate, chain: str, serial: int
) -> list[str]:
    """ATOM records of a trace: one point per loop nucleotide.

    Parameters
    ----------
    fold : LoopFold
        The loop.
    structure : Structure
        What it was found in.
    candidate : Candidate
        Whose trace it is; its expected error is the B factor.
    chain : str
        Letter of the chain.
    serial : int
        Number of the first atom.

    Returns
    -------
    list of str
    """
    from MDAnalysis.coordinates.PDB import PDBWriter

    hairpin, names = fold.hairpin, structure.nucleotides.resname
    return [
        PDBWriter.fmt["ATOM"]
        .format(
            serial=(serial + k) % 100_000,
            name=f" {POINT}",
            altLoc="",
            resName=f"{'N' if row < 0 else pdb_name(names[row])[:3]:>3s} ",
            chainID=chain,
            resSeq=int(hairpin.resid[k]) % 10_000 if hairpin.resid[k] >= 0 else hairpin.resid[k],
            iCode=pdb_name(hairpin.icode[k])[:1],
            pos=candidate.trace[k],
            occupancy=1.0,
            tempFactor=b_factor(float(candidate.expected_rmsd_A[1])),
            segID="",
            element="X",
            charge="",
        )
        .rstrip("\n")
        for k, row in enumerate(hairpin.loop)
    ]


def bond_records(serial: int, n: int) -> list[str]:
    """CONECT records that join points in a row.

    Parameters
    ----------
    serial : int
        Number of the first atom.
    n : int
        Number of points.

    Returns
    -------
    list of str
        Empty where serial numbers have run over the five digits of the format.
    """
    if serial + n > 100_000:
        return []
    return [f"CONECT{k:5d}{k + 1:5d}" for k in range(serial, serial + n - 1)]


class WholeStructure:
    """The first model of a structure as PDB records, to be written with a loop replaced.

    The records of a PDB file are kept byte for byte. Of other formats the records are made anew,
    and chains of several letters get one, which the file says.
    """

    def __init__(self, structure: Structure) -> None:
        self._structure = structure
        residues = structure.universe.atoms.resindices
        path = Path(structure.source) if structure.source else None
        self._records = pdb_records(path) if path and is_pdb(path) else []
        self._letters: dict[str, str] = {}
        if sum(record.startswith(_ATOMS) for record in self._records) != len(residues):
            chains = _chains(structure.universe)
            self._letters = chain_letters(structure)
            self._records = _made_anew(structure, [self._letters[chain] for chain in chains])
        atom = np.cumsum([record.startswith(_ATOMS) for record in self._records]) - 1
        own = np.array([record.startswith((*_ATOMS, "ANISOU")) for record in self._records])
        # The residue of each record, −1 for those of no residue.
        self._residue = np.where(own, residues[atom], -1)
        serials = [r[6:11].strip() for r in self._records if r.startswith(_ATOMS)]
        self._serial = 1 + max((int(serial) for serial in serials if serial.isdigit()), default=0)

    def write(self, path: Path, fold: LoopFold) -> None:
        """Write a PDB file: the first-ranked trace in place of the loop, all else as it was.

        Parameters
        ----------
        path : Path
            The file.
        fold : LoopFold
            A folded loop of the structure.
        """
        first, hairpin = fold.candidates[0], fold.hairpin
        keep = ~np.isin(self._residue, list(self._loop_residues(fold)))
        closing = self._residue_of(int(hairpin.stem_5[0]))
        after = int(np.flatnonzero(self._residue == closing)[-1]) + 1
        # the chain as the file has it, which may be blank where segments name the strands
        chain = self._records[after - 1][21]
        points = point_records(fold, self._structure, first, chain, self._serial)
        records = np.array(self._records, dtype=object)
        ends = printable(f"{hairpin.residues[0]} TO {hairpin.residues[-1]}")
        lines = [
            f"REMARK  99 LOOPELASTICA {__version__}: {ends} ARE POINTS {POINT} OF THE ELASTIC LINE",
            "REMARK  99 OF FIRST RANK; ALL OTHER ATOMS ARE THOSE OF THE INPUT, FIRST MODEL",
            *expected_records([first]),
            *renamed_records(self._letters),
            *records[:after][keep[:after]],
            *points,
            *records[after:][keep[after:]],
            *bond_records(self._serial, len(points)),
            "END",
        ]
        write_text(path, "\n".join([*lines, ""]))

    def _residue_of(self, row: int) -> int:
        table = self._structure.nucleotides
        return int(self._structure.universe.atoms.resindices[table.columns(("C1'",))[row, 0]])

    def _loop_residues(self, fold: LoopFold) -> Iterator[int]:
        """Residues of the loop, with those that share a place with one of them by altlocs."""
        universe, table = self._structure.universe, self._structure.nucleotides
        for row in fold.hairpin.loop[fold.hairpin.loop >= 0]:
            here = self._residue_of(int(row))
            yield here
            if table.altloc[row]:
                residues = universe.residues
                place = (residues.resids == residues.resids[here]) & (
                    residues.segids == residues.segids[here]
                )
                if hasattr(residues, "icodes"):
                    place &= residues.icodes == residues.icodes[here]
                yield from np.flatnonzero(place).tolist()


def _chains(universe: Any) -> list[str]:
    """Chain of each atom, else its segment, "" where the file names neither."""
    chains = getattr(universe.atoms, "chainIDs", universe.atoms.segids)
    segments = np.where(universe.atoms.segids == "SYSTEM", "", universe.atoms.segids)
    return [str(chain) for chain in np.where(chains == "", segments, chains)]


def _made_anew(structure: Structure, chains: list[str]) -> list[str]:
    """PDB records of the first model of a structure that came in another format."""
    with tempfile.TemporaryDirectory() as folder, quiet():
        path = Path(folder) / "whole.pdb"
        copy = structure.universe.copy()
        copy.add_TopologyAttr("chainIDs", chains)
        for name in ("names", "resnames", "altLocs", "icodes", "segids", "elements"):
            values = getattr(getattr(copy, _LEVEL.get(name, "atoms")), name, None)
            if values is not None:
                copy.add_TopologyAttr(name, [pdb_name(str(value)) for value in values])
        copy.atoms.positions = structure.positions(0)
        copy.atoms.write(str(path), bonds=None)
        # MDAnalysis begins residue names at the left, the format ends them at the right; and it
        # invents a unit cell
        records = [
            f"{r[:17]}{r[17:21].strip():>3s}{r[20:] if r[20] == ' ' else r[21:]}"
            if r.startswith(_ATOMS)
            else r
            for r in pdb_records(path)
            if not r.startswith("CRYST1")
        ]
        return cell_record(origin_of(structure)) + records
