"""Draw ``docs/rooms.svg``: which room of the package imports which, read from the code.

    python docs/rooms.py

The rooms and their order come from the layers that `pyproject.toml` demands, the arrows from the
import statements: left the rooms of the package, without arrows that others imply (a → c beside
a → b → c), right all imports between the modules of the rod. Imports that only a type checker
follows do not count; imports inside functions do. What leads upwards is drawn in another color,
with a dashed line.
"""

import ast
import re
import tomllib
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "loopelastica"

ABOUT = {
    "cli": "commands, progress",
    "studies": "bench, evaluate",
    "batch": "many files, workers",
    "filling": "gaps to structures",
    "report": "files, tables, pictures",
    "simulation": "restraints for OpenMM",
    "nanostructures": "scadnano, oxDNA",
    "atoms": "from line to residues",
    "folding": "structure to candidates",
    "molecule": "nucleotides, stems",
    "rod": "equilibria of a rod",
    "errors": "three exceptions",
    "_files": "write whole or not",
    "_names": "names made harmless",
    "_arrays": "read-only arrays",
    "_checks": "checks of arguments",
    "_html": "tables for notebooks",
    "_progress": "bars on a terminal",
    "_vectors": "products, directions",
    "datafiles": "structures to try",
    "_version": "the version",
    "rod.paper": "the printed method",
    "rod.warm": "compiles now",
    "rod.batch": "many clampings",
    "rod.equilibria": "all of one clamping",
    "rod.solve": "the lowest of one",
    "rod.continuation": "moving clampings",
    "rod._branch": "one step of a path",
    "rod._starts": "tables of starts",
    "rod._arguments": "checks of arguments",
    "rod.stability": "Morse index",
    "rod.equilibrium": "one solution",
    "rod.parameters": "closed form",
    "rod.writhe": "writhe, winding",
    "rod._contact": "near to itself",
    "rod._library": "guess library",
    "rod.clamping": "what is solved",
    "rod.kernels": "compiled code",
    "rod.deformed": "chains with a rest shape",
    "rod._chain_starts": "starts of chains",
    "rod.barriers": "passes between minima",
    "rod.surrounded": "among points that repel",
    "rod.chain": "many chains at once",
    "rod._turned": "passes by turned ends",
    "rod.descent": "what a saddle separates",
    "rod.morse": "what topology demands",
    "rod._discrete": "as a discrete rod",
    "rod._same": "when two are one",
    "rod._arc_start": "circular arcs, the start",
    "rod._arc_check": "… their forces, checked",
    "rod._arc_line": "… their line",
    "rod.rest_shape": "natural curvature",
    "rod.curves": "curves to begin with",
}
UNDRAWN = ("__main__",)
WIDTH, HEIGHT, SIDEWAYS, DOWNWARDS = 2.4, 0.74, 2.65, 1.24
INK, PAPER, LINE, UPWARD = "#22313f", "#eef3f8", "#c3ccd5", "#b3541e"


def layers(prefix):
    """Rooms in rows, top first, as the contract whose layers all begin with ``prefix`` has them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    for contract in settings["tool"]["importlinter"]["contracts"]:
        rows = [re.split(r"[|:]", row) for row in contract.get("layers", ())]
        names = [[name.strip(" ()").removeprefix(f"{PACKAGE}.") for name in row] for row in rows]
        inside = [name.startswith("rod.") for row in names for name in row]
        if inside and all(inside) == (prefix == "rod."):
            return [row for row in ([n for n in r if n not in UNDRAWN] for r in names) if row]
    raise SystemExit(f"pyproject.toml has no layers of {prefix or 'the package'}")


def imports(path):
    """Modules that a file imports when it runs: names inside the package."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found = []

    def visit(node):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            return
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(PACKAGE):
            found.extend(f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            found.extend(a.name for a in node.names if a.name.startswith(PACKAGE))
        for child in ast.iter_child_nodes(node):
            visit(child)

    visit(tree)
    return [name.removeprefix(f"{PACKAGE}.") for name in found]


def room_of(module, rooms):
    """The room that a module belongs to, or None."""
    fitting = [r for r in rooms if module == r or module.startswith(r + ".")]
    return max(fitting, key=len, default=None)


def arrows(rooms):
    """Pairs (who imports, what) of different rooms."""
    found = set()
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        module = ".".join(path.relative_to(ROOT / PACKAGE).with_suffix("").parts)
        source = room_of(module.removesuffix(".__init__"), rooms)
        for name in imports(path):
            target = room_of(name, rooms)
            if source and target and source != target:
                found.add((source, target))
    return found


def direct(pairs):
    """Those arrows that no chain of others implies."""
    after = {}
    for a, b in pairs:
        after.setdefault(a, set()).add(b)

    def reaches(a, b, seen):
        return any(
            c == b or (c not in seen and reaches(c, b, seen | {c})) for c in after.get(a, ())
        )

    return {
        (a, b)
        for a, b in pairs
        if not any(c != b and reaches(c, b, {a, c}) for c in after.get(a, ()))
    }


def draw_rooms(axes, rows):
    """Rooms as boxes in rows, with arrows."""
    most = max(len(row) for row in rows)
    place = {
        room: ((k - 0.5 * (len(row) - 1)) * SIDEWAYS, -level * DOWNWARDS)
        for level, row in enumerate(rows)
        for k, room in enumerate(row)
    }
    pairs = arrows(place)
    upward = {(a, b) for a, b in pairs if place[b][1] >= place[a][1]}
    for a, b in sorted(direct(pairs - upward)):
        if blocked(place, a, b):
            arrow_beside(axes, place[a], place[b], -1.0, INK, "-")
        else:
            arrow_down(axes, place[a], place[b])
    for a, b in sorted(upward):
        arrow_beside(axes, place[a], place[b], 1.0, UPWARD, "--")
    for room, (x, y) in place.items():
        corner = (x - 0.5 * WIDTH, y - 0.5 * HEIGHT)
        style = "round,pad=0.02,rounding_size=0.08"
        axes.add_patch(
            FancyBboxPatch(corner, WIDTH, HEIGHT, boxstyle=style, fc=PAPER, ec=INK, lw=0.9)
        )
        centered = {"ha": "center", "va": "center", "color": INK}
        axes.text(x, y + 0.15, room, fontsize=9.5, **centered)
        axes.text(x, y - 0.19, ABOUT.get(room, ""), fontsize=7, **centered)
    half = 0.5 * most * SIDEWAYS + 0.1
    axes.set(xlim=(-half, half), ylim=(-(len(rows) - 1) * DOWNWARDS - 0.5, 0.5), aspect="equal")
    axes.axis("off")


def blocked(place, a, b):
    """Whether another room lies on the straight way between two."""
    (xa, ya), (xb, yb) = place[a], place[b]
    return any(
        yb < y < ya and abs(xa + (xb - xa) * (y - ya) / (yb - ya) - x) < 0.5 * WIDTH + 0.1
        for room, (x, y) in place.items()
    )


def arrow_down(axes, start, end):
    """An arrow from the lower edge of one room to the upper edge of another."""
    down = 0.5 * HEIGHT + 0.04
    aside = max(-0.8, min(0.18 * (end[0] - start[0]), 0.8))
    add_arrow(axes, (start[0] + aside, start[1] - down), (end[0] - aside, end[1] + down), 0.0)


def arrow_beside(axes, start, end, side, color, style):
    """An arrow from the left (-1) or right (1) edge of one room to that of another."""
    edge = side * (0.5 * WIDTH + 0.04)
    curve = 0.5 if (end[1] < start[1]) == (side < 0.0) else -0.5
    add_arrow(axes, (start[0] + edge, start[1]), (end[0] + edge, end[1]), curve, color, style)


def add_arrow(axes, start, end, curve, color=INK, style="-"):
    """An arrow; ``curve`` is twice its height over its length."""
    axes.add_patch(
        FancyArrowPatch(
            start, end, arrowstyle="-|>", mutation_scale=9, color=color, lw=0.9, ls=style,
            connectionstyle=f"arc3,rad={curve}", shrinkA=0, shrinkB=0,
        )
    )  # fmt: skip


def draw_matrix(axes, rows):
    """Who (row) imports what (column): marks right of the diagonal point downwards."""
    rooms = [room for row in rows for room in row]
    count, rank = len(rooms), {room: k for k, room in enumerate(rooms)}
    done = 0
    for row in rows:
        axes.plot([-0.5, count - 0.5], [done - 0.5] * 2, color=LINE, lw=0.7)
        axes.plot([done - 0.5] * 2, [-0.5, count - 0.5], color=LINE, lw=0.7)
        done += len(row)
    axes.plot([-0.5, count - 0.5], [count - 0.5] * 2, color=LINE, lw=0.7)
    axes.plot([count - 0.5] * 2, [-0.5, count - 0.5], color=LINE, lw=0.7)
    for room, k in rank.items():
        name = room.rpartition(".")[2]
        axes.text(k, k, "■", ha="center", va="center", fontsize=8, color=LINE)
        axes.text(k - 0.2, -0.8, name, ha="left", va="bottom", rotation=55, fontsize=9, color=INK)
        axes.text(-0.8, k, name, ha="right", va="center", fontsize=9, color=INK)
        about = ABOUT.get(room, "")
        axes.text(count - 0.2, k, about, ha="left", va="center", fontsize=7, color=INK)
    for a, b in sorted(arrows(rooms)):
        color = INK if rank[b] > rank[a] else UPWARD
        axes.plot(rank[b], rank[a], "o", ms=6, color=color)
    axes.set(xlim=(-5.0, count + 5.0), ylim=(count - 0.3, -4.5), aspect="equal")
    axes.axis("off")


def main():
    """Write the picture."""
    # the same code gives the same file
    matplotlib.rcParams.update({"svg.hashsalt": PACKAGE, "font.family": "DejaVu Sans"})
    figure = Figure(figsize=(15.0, 7.8), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    left.set_title(f"{PACKAGE}: arrows point at what is imported", fontsize=11, color=INK)
    draw_rooms(left, layers(""))
    title = f"{PACKAGE}.rod: the row imports the column"
    right.set_title(title, fontsize=11, color=INK, pad=22)
    draw_matrix(right, layers("rod."))
    figure.savefig(ROOT / "docs" / "rooms.svg", metadata={"Date": None, "Creator": None})
    return figure


if __name__ == "__main__":
    main()
