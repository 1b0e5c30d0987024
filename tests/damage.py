"""Known moves that damage a PDB file, and what can be read from its text by columns alone."""

import numpy as np

from loopelastica._files import data_path

SUGAR = ("C1'", "C2'", "C3'", "C4'", "O4'", "O2'")
ATOM = ("ATOM", "HETATM")
ACROSS = {("O3'", "P"), ("O3'", "O5'"), ("O3'", "OP1"), ("O3'", "OP2"), ("C3'", "P")}


def first_model() -> list[str]:
    """Lines of a hairpin with a sequence of record, its first model alone."""
    lines = data_path("hairpins/2koc.pdb").read_text().splitlines()
    end = next(k for k, line in enumerate(lines) if line.startswith("ENDMDL"))
    return [line for line in lines[:end] if not line.startswith("MODEL")] + ["END"]


def key(line: str) -> tuple[int, str]:
    """Residue number and name of an atom."""
    return int(line[22:26]), line[12:16].strip()


def place(line: str) -> np.ndarray:
    """Coordinates of an atom, Å."""
    return np.array([float(line[k : k + 8]) for k in (30, 38, 46)])


def rows(lines: list[str]) -> list[str]:
    """Lines of atoms."""
    return [line for line in lines if line.startswith(ATOM)]


def heavy(lines: list[str]) -> dict[tuple[int, str], np.ndarray]:
    """Heavy atoms by number and name."""
    return {key(line): place(line) for line in rows(lines) if line[76:78].strip() != "H"}


def moved(lines: list[str], where) -> list[str]:
    """The lines with atoms where `where` (number, name, place) says; None: as they are."""
    out = []
    for line in lines:
        at = where(*key(line), place(line)) if line.startswith(ATOM) else None
        out.append(
            line if at is None else line[:30] + "{:8.3f}{:8.3f}{:8.3f}".format(*at) + line[54:]
        )
    return out


def shifted(lines: list[str], first: int, last: int, by) -> list[str]:
    """A stretch somewhere else, as a whole."""
    return moved(lines, lambda n, _, at: at + np.asarray(by) if first <= n <= last else None)


def broken(lines: list[str], number: int, by) -> list[str]:
    """A phosphate somewhere else."""
    names = ("P", "OP1", "OP2")
    return moved(lines, lambda n, x, at: at + by if n == number and x in names else None)


def mirrored(lines: list[str], number: int) -> list[str]:
    """A sugar behind the plane of what it is bonded to: all lengths right, all hands wrong."""
    atoms = heavy(lines)
    base = "N9" if (number, "N9") in atoms else "N1"
    a, b, c = (atoms[number, name] for name in (base, "C5'", "O3'"))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)

    def where(n, name, at):
        return at - 2.0 * ((at - a) @ normal) * normal if n == number and name in SUGAR else None

    return moved(lines, where)


def without(lines: list[str], *numbers: int) -> list[str]:
    """The lines without the atoms of some nucleotides."""
    return [x for x in lines if not (x.startswith(ATOM) and key(x)[0] in numbers)]


def wrong(lines: list[str]) -> list[str]:
    """What is wrong in a whole chain: bonds, hands and contacts, by other code than ours."""
    atoms = heavy(lines)
    numbers = sorted({number for number, _ in atoms})
    found = []
    for n in numbers[:-1]:
        bond = np.linalg.norm(atoms[n, "O3'"] - atoms[n + 1, "P"])
        if abs(bond - 1.607) > 0.06:
            found.append(f"bond {n}: {bond:.2f}")
    for n in numbers:
        base = "N9" if (n, "N9") in atoms else "N1"
        for centre, *names in (
            ("C1'", "O4'", "C2'", base),
            ("C2'", "C1'", "O2'", "C3'"),
            ("C3'", "C4'", "C2'", "O3'"),
            ("C4'", "C5'", "C3'", "O4'"),
        ):
            arms = [atoms[n, name] - atoms[n, centre] for name in names]
            if np.linalg.det(arms) < 1.0:
                found.append(f"hand {n} {centre}")
    keys = list(atoms)
    places = np.array([atoms[k] for k in keys])
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    for i, j in np.argwhere(np.triu(apart < 2.2, 1)):
        (n, x), (m, y) = sorted((keys[i], keys[j]))
        if n != m and not (m == n + 1 and (x, y) in ACROSS):
            found.append(f"contact {n}:{x} {m}:{y}")
    return found


def rmsd(lines: list[str], truth: list[str], numbers) -> float:
    """Of the heavy atoms of some nucleotides, without superposition, Å."""
    now, then = heavy(lines), heavy(truth)
    apart = [now[k] - then[k] for k in then if k[0] in numbers]
    return float(np.sqrt(np.mean(np.sum(np.square(apart), axis=1))))
