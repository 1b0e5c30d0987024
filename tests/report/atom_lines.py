"""Lines of atoms, for tests that write them and that read them."""

LOOP = range(6, 10)


def line(
    serial, name, resname, chain, number, at, *, altloc=" ", kind="ATOM", occupancy=1.0, **more
):
    """An atom of a PDB file; `element` is left out where it is ""."""
    element = more.get("element", name.strip("0123456789'")[:1])
    icode, segment = more.get("icode", " "), more.get("segment", "")
    x, y, z = at
    shown = name if len(name) == 4 else f" {name}"
    return (
        f"{kind:6s}{serial:5d} {shown:4s}{altloc}{resname:>3s} {chain:1s}{number:4d}{icode}   "
        f"{x:8.3f}{y:8.3f}{z:8.3f}{occupancy:6.2f}{5.0:6.2f}      {segment:4s}{element:>2s}"
    )


def records(text, model=1):
    """Atoms of one model."""
    part = text.split("ENDMDL")[model - 1]
    return [one for one in part.splitlines() if one.startswith(("ATOM", "HETATM"))]


def identity(one):
    """Name, residue, number and place of an atom."""
    return one[12:16].strip(), one[17:20].strip(), one[21:27], one[30:54]


def is_hydrogen(one):
    """By its element."""
    return one[76:78].strip() == "H"


def number(one):
    """Of its residue."""
    return int(one[22:26])
