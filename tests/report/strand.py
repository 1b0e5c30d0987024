"""Strands of a few atoms per nucleotide, whose ends are bonded where their numbers follow."""

from loopelastica.report.compose import AddedResidue

# name, element, place along the strand and beside it, Å; 7 Å per nucleotide, O3'-P 1.6 Å
ATOMS = (
    ("P", "P", 0.0, 0.0),
    ("OP1", "O", 0.0, 1.5),
    ("O5'", "O", 1.3, 0.0),
    ("C5'", "C", 2.3, 0.0),
    ("C4'", "C", 3.3, 0.0),
    ("C3'", "C", 4.3, 0.0),
    ("O3'", "O", 5.4, 0.0),
    ("C1'", "C", 3.3, 2.0),
    ("N1", "N", 3.3, 3.5),
)
NAMES = tuple(atom[0] for atom in ATOMS)


def place_of(number, name, lift=0.0):
    atom = ATOMS[NAMES.index(name)]
    return (7.0 * number + atom[2], atom[3], lift)


def added(number, after, names=NAMES, chain="A", icode="", resname="U", model=0, **more):
    """A nucleotide where its number says it is."""
    after = (chain, after, "") if isinstance(after, int) else after
    rows = [NAMES.index(name) for name in names]
    return AddedResidue(
        model,
        chain,
        number,
        icode,
        resname,
        after,
        names,
        tuple(ATOMS[k][1] for k in rows),
        [place_of(number, ATOMS[k][0], model) for k in rows],
        **more,
    )


def pdb_lines(numbers, chain="A", serial=1, names=NAMES, resname="U", record="ATOM", model=0):
    """ATOM records of a strand."""
    out = []
    for number in numbers:
        for name in names:
            x, y, z = place_of(number, name, model)
            element = ATOMS[NAMES.index(name)][1]
            out.append(
                f"{record:<6}{serial:5d}  {name:<3} {resname:>3} {chain}{number:4d}    "
                f"{x:8.3f}{y:8.3f}{z:8.3f}  1.00 20.00          {element:>2}  "
            )
            serial += 1
    return out


_COLUMNS = (
    *("group_PDB", "id", "type_symbol", "label_atom_id", "label_alt_id", "label_comp_id"),
    *("label_asym_id", "label_entity_id", "label_seq_id", "pdbx_PDB_ins_code"),
    *("Cartn_x", "Cartn_y", "Cartn_z", "occupancy", "B_iso_or_equiv", "pdbx_formal_charge"),
    *("auth_seq_id", "auth_comp_id", "auth_asym_id", "auth_atom_id", "pdbx_PDB_model_num"),
)


def cif_text(numbers, *more, models=1, without=(), waters=()):
    """An mmCIF file of a strand: chain A of the file is X of the author, numbers 100 higher."""
    rows, serial = [], 0
    for model in range(models):
        atoms = [(n, name, "U", "A", 1, n) for n in numbers for name in NAMES]
        atoms += [(n, "O", "HOH", "B", 2, ".") for n in waters]
        for number, name, comp, asym, entity, seq in atoms:
            serial += 1
            x, y, z = place_of(number, name, model) if comp == "U" else (number, 50.0, model)
            values = dict(
                zip(
                    _COLUMNS,
                    (
                        *("ATOM" if comp == "U" else "HETATM", serial, name[0], f'"{name}"', "."),
                        *(comp, asym, entity, seq, "?", f"{x:.3f}", f"{y:.3f}", f"{z:.3f}"),
                        *("1.00", "20.00", "?", number + 100, comp, "X", f'"{name}"', model + 1),
                    ),
                    strict=True,
                )
            )
            rows.append(" ".join(str(v) for k, v in values.items() if k not in without))
    columns = [f"_atom_site.{column}" for column in _COLUMNS if column not in without]
    return "\n".join(["data_test", *more, "loop_", *columns, *rows, ""])
