"""Designs of helices that several tests read, drawn by scadnano itself."""

import json

import numpy as np
import pytest

sc = pytest.importorskip("scadnano")


def write(design, path):
    """The path of a design's file, in a folder or at a place."""
    path = path / "design.sc" if path.is_dir() else path
    path.write_text(design if isinstance(design, str) else design.to_json())
    return path


def changed(design, path, change):
    """A design's file after a change of its JSON."""
    content = json.loads(design.to_json())
    change(content)
    path = path / "changed.sc"
    path.write_text(json.dumps(content))
    return path


def row_of(n_helices, length=64, **geometry):
    """Helices without strands, one below the other."""
    helices = [sc.Helix(max_offset=length) for _ in range(n_helices)]
    return sc.Design(helices=helices, grid=sc.square, geometry=sc.Geometry(**geometry))


def duplex(length=32, **geometry):
    """One helix with both strands whole."""
    design = row_of(1, length, **geometry)
    design.draw_strand(0, 0).move(length)
    design.draw_strand(0, length).move(-length)
    return design


def hairpin(loop=5, stem=12):
    """A strand that goes back along its helix after a loopout."""
    design = row_of(1)
    design.draw_strand(0, 0).move(stem).loopout(0, loop).move(-stem)
    return design


def hairpins(count, loop=6, stem=10):
    """Many of them, side by side."""
    helices = [sc.Helix(max_offset=stem, grid_position=(i % 40, i // 40)) for i in range(count)]
    # all at once: after each strand that is drawn scadnano checks the whole design
    strands = [
        sc.Strand([sc.Domain(i, True, 0, stem), sc.Loopout(loop), sc.Domain(i, False, 0, stem)])
        for i in range(count)
    ]
    return sc.Design(helices=helices, strands=strands, grid=sc.square)


def linker(length, apart=1):
    """Two helices, and a strand that leaves one and goes on along the other."""
    design = row_of(apart + 1)
    design.draw_strand(0, 0).move(20).loopout(apart, length).move(-20)
    design.draw_strand(0, 20).move(-20)
    design.draw_strand(apart, 0).move(20)
    return design


def turned_groups(minor_groove_angle, seed=1):
    """Groups of helices on all grids, turned and rolled at random, with inserted bases and not."""
    rng = np.random.default_rng(seed)
    names = ("square", "honeycomb", "hex", "none")
    groups = {
        name: sc.HelixGroup(
            position=sc.Position3D(*rng.uniform(-50, 50, 3)),
            pitch=rng.uniform(-180, 180),
            yaw=rng.uniform(-180, 180),
            roll=rng.uniform(-180, 180),
            grid=sc.Grid[name],
        )
        for name in names
    }
    helices = []
    for name in names:
        for i in range(4):
            place = (
                {"position": sc.Position3D(*rng.uniform(-9, 9, 3))}
                if name == "none"
                else {"grid_position": (i % 2, i // 2)}
            )
            roll = rng.uniform(0, 360)
            helices.append(sc.Helix(min_offset=-10, max_offset=60, group=name, roll=roll, **place))
    geometry = sc.Geometry(
        minor_groove_angle=minor_groove_angle, inter_helix_gap=0.4, bases_per_turn=10.67
    )
    design = sc.Design(helices=helices, groups=groups, geometry=geometry)
    for i in range(len(helices)):
        for start, length in ((-8, 50), (42, -50)):
            strand = design.draw_strand(i, start).move(length)
            strand.with_insertions([(3, 2), (20, 1)]).with_deletions([10, 11])
    return design


def exported(design):
    """What scadnano's own exporter writes: centre, a1 and a3 of each nucleotide."""
    configuration, _ = design.to_oxdna_format()
    lines = configuration.splitlines()[3:]
    return np.hsplit(np.array([[float(word) for word in line.split()[:9]] for line in lines]), 3)
