"""An mmCIF file with atoms added, moved and left out; all categories stay, in their order."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Any, Final

from loopelastica.errors import StructureError
from loopelastica.report.changes import Changes
from loopelastica.report.cif_categories import Written, raw, text_of, with_categories
from loopelastica.report.placing import NewAtom, Row, plan_for, record_name, renumbered

_WIDTH: Final = 33
_AXES: Final = ("cartn_x", "cartn_y", "cartn_z")
# what an atom has in common with all others of its residue, and of its chain
_OF_RESIDUE: Final = (
    *("group_pdb", "label_comp_id", "auth_comp_id", "label_seq_id", "auth_seq_id"),
    "pdbx_pdb_ins_code",
)
_OF_CHAIN: Final = ("pdbx_pdb_model_num", "ihm_model_id", "label_entity_id", "auth_asym_id")


def compose_cif(text: str, changes: Changes) -> str:
    """The text of an mmCIF file with changes.

    Parameters
    ----------
    text : str
        The file.
    changes : Changes

    Raises
    ------
    StructureError
        If it has no atoms, or the changes do not fit the file.
    """
    from gemmi import cif

    document = cif.read_string(text)
    block = next((b for b in document if b.find_loop("_atom_site.id").get_loop()), None)
    if block is None:
        raise StructureError("the file has no table _atom_site, so nothing can be added to it")
    site = _AtomSite(block.find_loop("_atom_site.id").get_loop())
    plan = plan_for(site.rows, site.position_A, changes)
    order: list[int | NewAtom] = []
    for row in range(len(site.rows)):
        order += plan.before.get(row, [])
        if row not in plan.gone:
            order.append(row)
        order += plan.after.get(row, [])
    for row, position in plan.moved.items():
        site.move(row, position, changes)
    written = site.reorder(order, _Seqs(block, site))
    with_categories(block, written, plan, changes)
    options = cif.WriteOptions()
    options.misuse_hash = True
    options.align_pairs = options.align_loops = _WIDTH
    out: str = document.as_string(options)
    return out


class _AtomSite:
    """The table of atoms, by its columns; names of columns in lower case."""

    def __init__(self, loop: Any) -> None:
        self._loop = loop
        values, width = loop.values, loop.width()
        names = [tag.partition(".")[2].lower() for tag in loop.tags]
        self.columns = {name: values[k::width] for k, name in enumerate(names)}
        nothing = ["?"] * loop.length()
        models = self.columns.get("pdbx_pdb_model_num", nothing)
        self.model_names = list(dict.fromkeys(models))
        index = {name: k for k, name in enumerate(self.model_names)}
        labels = self._texts("label_asym_id")
        # an author's chain may have no name, which is no chain of the file's own
        chains = self._texts("auth_asym_id") if "auth_asym_id" in self.columns else labels
        columns = (
            chains,
            self._texts("auth_seq_id", "label_seq_id"),
            self._texts("pdbx_pdb_ins_code"),
            self._texts("label_comp_id", "auth_comp_id"),
            self._texts("label_atom_id", "auth_atom_id"),
            self._texts("label_alt_id"),
            labels,
        )
        self.rows = [
            Row(index[m], (chain, _integer(number), icode), comp, name, alt, asym, chain or asym)
            for m, chain, number, icode, comp, name, alt, asym in zip(models, *columns, strict=True)
        ]

    def _texts(self, *names: str) -> list[str]:
        """A column without quotes; where it has no value, or is absent, the next one."""
        out = [""] * self._loop.length()
        for name in reversed(names):
            if name in self.columns:
                texts = map(text_of, self.columns[name])
                out = [text or other for text, other in zip(texts, out, strict=True)]
        return out

    def position_A(self, row: int) -> list[float]:
        """Where an atom is, Å."""
        # a standard uncertainty may follow in parentheses
        return [float(self.columns[axis][row].partition("(")[0]) for axis in _AXES]

    def move(self, row: int, position_A: Iterable[float], changes: Changes) -> None:
        """Put an atom elsewhere; of its locations one is left."""
        new = {axis: f"{x:.3f}" for axis, x in zip(_AXES, position_A, strict=True)}
        new |= {f"{axis}_esd": "?" for axis in _AXES}
        new["label_alt_id"] = "."
        for name, value in (
            ("occupancy", changes.moved_occupancy),
            ("b_iso_or_equiv", changes.moved_b_factor_A2),
        ):
            if value is not None:
                new[name] = f"{value:.2f}"
        for name, text in new.items():
            if name in self.columns:
                self.columns[name][row] = text

    def reorder(self, order: list[int | NewAtom], seqs: _Seqs) -> Written:
        """Write the rows in their new order, new ones among them."""
        groups = dict(zip(self._texts("label_comp_id"), self._texts("group_pdb"), strict=True))
        seq_ids: dict[int, str] = {}
        values: dict[int, dict[str, str]] = {}
        for k, item in enumerate(order):
            if isinstance(item, NewAtom):
                key = id(item.residue)
                if key not in seq_ids:
                    seq_ids[key] = seqs.of(item)
                values[k] = self._values(item, seq_ids[key], groups)
        old = self.columns["id"]
        ids = [None if isinstance(item, NewAtom) else old[item] for item in order]
        new_ids = _numbered(ids, bool(values))
        columns = [
            new_ids
            if name == "id"
            else [
                values[k].get(name, "?") if isinstance(item, NewAtom) else column[item]
                for k, item in enumerate(order)
            ]
            for name, column in self.columns.items()
        ]
        self._loop.set_all_values(columns)
        now = {o: n for o, n in zip(ids, new_ids, strict=True) if o is not None}
        entities = self.columns.get("label_entity_id", [])
        return Written(self.rows, self.model_names, now, old, entities, seq_ids)

    def _values(self, atom: NewAtom, seq_id: str, groups: dict[str, str]) -> dict[str, str]:
        """The values of a new row; of columns that are not named there is none."""
        residue, k = atom.residue, atom.atom
        occupancy, b_factor_A2 = residue.numbers(k)
        like = self.columns.get("group_pdb", {atom.like: "ATOM"})[atom.like]
        name, comp = raw(atom.name), raw(residue.resname)
        values = {
            "group_pdb": record_name(atom, like, groups),
            "type_symbol": residue.elements[k].upper(),
            "label_atom_id": name,
            "auth_atom_id": name,
            "label_alt_id": raw(atom.altloc) if atom.altloc else ".",
            "label_comp_id": comp,
            "auth_comp_id": comp,
            "label_asym_id": raw(residue.asym or self.rows[atom.like].asym),
            "label_seq_id": seq_id,
            "auth_seq_id": str(residue.number),
            "pdbx_pdb_ins_code": raw(residue.icode) if residue.icode else "?",
            "occupancy": f"{occupancy:.2f}",
            "b_iso_or_equiv": f"{b_factor_A2:.2f}",
        }
        values |= {
            axis: f"{x:.3f}" for axis, x in zip(_AXES, residue.positions_A[k].tolist(), strict=True)
        }
        shared = (*_OF_CHAIN, *(_OF_RESIDUE if atom.completes else ()))
        values |= {name: self.columns[name][atom.like] for name in shared if name in self.columns}
        return values


class _Seqs:
    """Places in the sequence of record, as `label_seq_id` has them."""

    def __init__(self, block: Any, site: _AtomSite) -> None:
        self._site = site
        scheme = block.find("_pdbx_poly_seq_scheme.", ["pdb_strand_id", "pdb_seq_num", "seq_id"])
        icodes = block.find_values("_pdbx_poly_seq_scheme.pdb_ins_code")
        self._scheme: dict[tuple[str, str, str], str] = {
            (text_of(row[0]), text_of(row[1]), text_of(icodes[k]) if icodes else ""): row[2]
            for k, row in enumerate(scheme)
        }
        nothing = ["?"] * len(site.rows)
        self._asyms = site.columns.get("label_asym_id", nothing)
        self._seqs = site.columns.get("label_seq_id", nothing)
        self._used = set(zip(self._asyms, self._seqs, strict=True))

    def of(self, atom: NewAtom) -> str:
        """That of an added nucleotide: as given, as the scheme has it, as numbers have room."""
        residue = atom.residue
        if residue.record is not None:
            return str(residue.record)
        chain, number, icode = residue.place
        found = self._scheme.get((chain, str(number), icode))
        if found is not None:
            return found
        like = self._site.rows[atom.like]
        seq = self._seqs[atom.like]
        if not seq.isdecimal() or icode or like.place[2]:
            return "?"
        own = str(int(seq) + number - like.place[1])
        return "?" if (self._asyms[atom.like], own) in self._used else own


def _numbered(ids: list[str | None], has_new: bool) -> list[str]:
    """Unique ids that rise, if they did before; else new ones above all others."""
    if not has_new:
        return [text for text in ids if text is not None]
    olds = [text for text in ids if text is not None]
    numbers = [int(text) if text.isdecimal() else -1 for text in olds]
    if all(a < b for a, b in pairwise([-1, *numbers])):
        own = [None if text is None else int(text) for text in ids]
        return [str(number) for number in renumbered(own, {}, min(numbers, default=1) - 1)]
    fresh = iter(range(max(numbers, default=0) + 1, 2 * len(ids) + max(numbers, default=0) + 2))
    return [str(next(fresh)) if text is None else text for text in ids]


def _integer(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        return 0
