"""Records of PDB and mmCIF files in which nucleotides are missing."""

from __future__ import annotations

from collections.abc import Callable, Iterable

SEQUENCE = "GGCACUUCGGUGCC"


def numbered(line: str) -> int:
    """Residue number of an atom record."""
    return int(line[22:26])


def seqres(names: Iterable[str], chain: str = "A") -> list[str]:
    """SEQRES records of a chain."""
    names = list(names)
    return [
        f"SEQRES {k // 13 + 1:3d} {chain} {len(names):4d}  "
        + " ".join(f"{name:>3s}" for name in names[k : k + 13])
        for k in range(0, len(names), 13)
    ]


def remark_465(rows: Iterable[tuple[str, str, str]]) -> list[str]:
    """REMARK 465 of residues that were not observed: name, chain, number with insertion code."""
    found = ["REMARK 465", "REMARK 465 MISSING RESIDUES", "REMARK 465   M RES C SSSEQI"]
    for name, chain, place in rows:
        number, code = (place, " ") if place[-1].isdigit() else (place[:-1], place[-1])
        found.append(f"REMARK 465     {name:>3s} {chain} {number:>5s}{code}")
    return found


_SITE = (
    *("group_PDB", "id", "type_symbol", "label_atom_id", "label_alt_id", "label_comp_id"),
    *("label_asym_id", "label_entity_id", "label_seq_id", "pdbx_PDB_ins_code"),
    *("Cartn_x", "Cartn_y", "Cartn_z", "occupancy", "B_iso_or_equiv"),
    *("auth_seq_id", "auth_comp_id", "auth_asym_id", "auth_atom_id", "pdbx_PDB_model_num"),
)


def mmcif_sites(
    records: Iterable[str],
    *,
    label: str = "A",
    chain: str = "A",
    seq: Callable[[int], int | str] = lambda n: n,
) -> list[str]:
    """Rows of _atom_site of PDB records; `seq` gives label_seq_id by the author's number."""
    rows = []
    for k, line in enumerate(records, start=1):
        atom, residue = line[12:16].strip(), line[17:20].strip()
        code = line[26].strip() or "?"
        rows.append(
            f'ATOM {k} {line[76:78].strip()} "{atom}" . {residue} {label} 1 {seq(numbered(line))}'
            f" {code} {line[30:38]} {line[38:46]} {line[46:54]} 1.0 10.0 {numbered(line)}"
            f' {residue} {chain} "{atom}" 1'
        )
    return ["loop_", *(f"_atom_site.{column}" for column in _SITE), *rows]


def mmcif_loop(category: str, columns: str, rows: Iterable[Iterable[object]]) -> list[str]:
    """A loop of an mmCIF file."""
    return [
        "loop_",
        *(f"_{category}.{column}" for column in columns.split()),
        *(" ".join(str(value) for value in row) for row in rows),
        "#",
    ]
