"""
A folded loop, rendered by PyMOL
================================

Draws the picture at the head of the README: the sarcin/ricin hairpin 430D with its GAGA loop folded
from the stem alone, its atoms in blue and its elastic line in orange, and the loop that the
crystal has, in black, where it is. Nothing is superposed. Needs PyMOL: ``apt install pymol``.
"""

# %%
# Fold it, with atoms
# -------------------
# No loop with a related sequence is used.

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import MDAnalysis as mda
import numpy as np

import loopelastica as le
from loopelastica.datafiles import RNA_430D

pymol = shutil.which("pymol")
if pymol is None:
    sys.exit("this picture needs PyMOL (Debian: apt install pymol), which is not there")

(loop,) = le.fold(RNA_430D, exclude_relatives=True)
first = loop.candidates[0]
print(f"{first.shape}: {first.rmsd_A:.2f} Å from the loop of the crystal")
scratch = tempfile.TemporaryDirectory()
folder = Path(scratch.name)
subprocess.run(
    [sys.executable, "-m", "loopelastica", "fold", RNA_430D, "--atoms",
     "--exclude-relatives", "--candidates", "1", "-o", folder / "fold"],
    check=True, capture_output=True,
)  # fmt: skip
(atoms,) = folder.glob("fold/*/atoms.pdb")

# %%
# The scene
# ---------
# A script that PyMOL runs.

numbers = "+".join(str(number) for number in loop.hairpin.resid)
line = first.line.points(200).round(3)
# the camera: the stem lies along x, the loop at its right end, seen broadside
stem = mda.Universe(RNA_430D).select_atoms("nucleic").positions
axis = line.mean(axis=0) - stem.mean(axis=0)
axis /= np.linalg.norm(axis)
across = line[-1] - line[0]
across -= across @ axis * axis
across /= np.linalg.norm(across)
axes = np.array([axis, across, np.cross(axis, across)])
SCENE = f"""
import numpy as np
from pymol import cmd
from pymol.cgo import BEGIN, COLOR, CYLINDER, END, NORMAL, SPHERE, TRIANGLES, VERTEX

cmd.load({RNA_430D!r}, "native")
cmd.load({str(atoms)!r}, "folded")
cmd.hide("everything")
cmd.remove("solvent or inorganic")
for name, value in dict(
    auto_zoom=0, bg_rgb="white", ray_opaque_background=1, antialias=2, field_of_view=22,
    ray_trace_mode=1, ray_trace_gain=0.08, ray_trace_disco_factor=1, ray_shadows=0, ambient=0.45,
    direct=0.5, reflect=0.35, specular=0.15, spec_reflect=0.2, light_count=3, depth_cue=0,
    cartoon_nucleic_acid_mode=4, cartoon_ring_mode=3, cartoon_ring_finder=1,
    cartoon_ladder_mode=1, cartoon_tube_radius=0.55, stick_radius=0.17, stick_quality=16,
    cartoon_ring_width=0.25, cartoon_sampling=14, valence=0,
).items():
    cmd.set(name, value)
cmd.set_color("stem", [0.80, 0.83, 0.87])
cmd.set_color("base", [0.34, 0.71, 0.91])

# the stem as the crystal has it
cmd.create("stem", "native and polymer.nucleic and not resi {numbers}")
cmd.show("cartoon", "stem")
cmd.color("stem", "stem")
# the loop of the crystal
cmd.create("own", "native and resi {numbers}")
cmd.hide("everything", "own")
cmd.show("sticks", "own")
cmd.color("grey30", "own")
cmd.set("stick_radius", 0.11, "own")
# the loop that was folded
cmd.create("built", "folded and resi {numbers} and not elem H")
cmd.hide("everything", "built")
cmd.show("sticks", "built")
cmd.color("base", "built")
cmd.set("stick_radius", 0.21, "built")
# its elastic line
line = {line.tolist()}
tube = [COLOR, 0.84, 0.37, 0.0]
for a, b in zip(line, line[1:]):
    tube += [CYLINDER, *a, *b, 0.5, 0.84, 0.37, 0.0, 0.84, 0.37, 0.0]
for point in line:
    tube += [SPHERE, *point, 0.5]
cmd.load_cgo(tube, "line")
cmd.delete("native")
cmd.delete("folded")
view = list(cmd.get_view())
view[:9] = {axes.T.ravel().round(6).tolist()}
cmd.set_view(view)
cmd.turn("x", 160)
cmd.turn("y", -10)
# its rings are filled; their normals look into the camera
view = cmd.get_view()
toward = np.array([view[2], view[5], view[8]])
fills = [COLOR, 0.56, 0.80, 0.95]
for residue in {numbers.split("+")}:
    places = {{a.name: np.array(a.coord) for a in cmd.get_model("built and resi " + residue).atom}}
    for ring in ("N9 C8 N7 C5 C4", "N1 C2 N3 C4 C5 C6", "C1' C2' C3' C4' O4'"):
        if not all(name in places for name in ring.split()):
            continue
        corners = [places[name] for name in ring.split()]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal *= np.sign(normal @ toward) / np.linalg.norm(normal)
        for one, two in zip(corners[1:], corners[2:]):
            fills += [BEGIN, TRIANGLES, NORMAL, *normal]
            for corner in (corners[0], one, two):
                fills += [VERTEX, *corner]
            fills += [END]
cmd.load_cgo(fills, "fills")
# the loop from nearby, and the whole upright
cmd.zoom("built", 1.5)
cmd.move("x", 4.5)
cmd.png({str(folder / "near.png")!r}, width=740, height=600, dpi=150, ray=1)
cmd.turn("z", 90)
cmd.zoom("stem or built", 7)
cmd.png({str(folder / "whole.png")!r}, width=330, height=600, dpi=150, ray=1)
"""
(folder / "scene.py").write_text(SCENE)

# %%
# Debian's ``pymol`` runs the first ``python3`` of PATH: it must be the one beside it, not that of a
# virtual environment.

environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
environment["PATH"] = os.pathsep.join([str(Path(pymol).parent), os.environ["PATH"]])
done = subprocess.run(
    [pymol, "-cq", folder / "scene.py"], env=environment, capture_output=True, text=True
)
if not (folder / "whole.png").exists():
    sys.exit(f"PyMOL did not draw the picture: {(done.stdout + done.stderr).strip()[-300:]}")
both = [plt.imread(folder / name)[:, :, :3] for name in ("whole.png", "near.png")]
plt.imsave("render_hairpin.png", np.concatenate(both, axis=1))
print("written to render_hairpin.png")
