"""
Single strands of a DNA nanostructure
=====================================

A design drawn with scadnano: three helices, joined by linkers, closed by a hairpin, with a tail.
Exporters put such single strands on straight chords, from which molecular dynamics cannot start.
Here each is an elastic rod that is clamped to its helices.
"""

# %%
# A design
# --------
# The package scadnano (``pip install loopelastica[origami]``) draws it. Any file of scadnano does
# as well, and so does a topology of oxDNA with its configuration.

import sys

import matplotlib.pyplot as plt
import numpy as np

try:
    import scadnano as sc
except ImportError:
    sys.exit("this example draws its design with scadnano: pip install loopelastica[origami]")

import loopelastica as le
from loopelastica.nanostructures.oxdna.model import UNIT_NM, backbone_sites

design = sc.Design(helices=[sc.Helix(max_offset=32) for _ in range(3)], grid=sc.square)
# down one helix, back along the next, down the third and back after a hairpin
strand = design.draw_strand(0, 0).move(32).loopout(1, 10).move(-32)
strand.loopout(2, 14).move(32).loopout(2, 7).move(-32)
design.draw_strand(0, 32).move(-32).extension_3p(12)
design.draw_strand(1, 0).move(32)
design.write_scadnano_file(filename="design.sc")

# %%
# Every single strand gets its place
# ----------------------------------
# What is paired stays where the design draws it. What cannot be spanned would be in ``refused``,
# with the reason.

found = le.nanostructure("design.sc")
for row in found.records():
    ends = " to ".join(end for end in (row["before"], row["after"]) if end)
    print(f"{row['kind']} of {row['nucleotides']} at {ends}: {row['status']}, {row['shape']}")
for note in found.notes:
    print("note:", note)

# %%
# Files
# -----
# For oxDNA a topology and a configuration, for viewers a coarse trace, a PyMOL script and a file of
# oxView, both in the colours of the design; and a record of everything in JSON.

found.write("nanostructure")
check = found.check()
print("bonds in the window of the model, no two centres too near:", check.sound)

# %%
# A picture
# ---------
# On the left what an exporter does with single strands: nucleotides on straight chords, as far from
# each other as there is room. On the right the rods. Both seen across the helices.

system = found.system
sites = backbone_sites(system.centre, system.a1, system.a3) * UNIT_NM
on_chord = sites.copy()
for one in found.strands:
    n = len(one)
    if one.before >= 0 and one.after >= 0:
        share = np.arange(1, n + 1)[:, None] / (n + 1)
        on_chord[one.nucleotides] = (1 - share) * sites[one.before] + share * sites[one.after]

turn = np.radians(25)  # a little from above, so that no helix hides another
view = np.array([[0, np.sin(turn), np.cos(turn)], [np.sin(turn), -np.cos(turn), 0]])
single = system.pair < 0
figure, panels = plt.subplots(2, 1, figsize=(6.4, 6.6), sharex=True, sharey=True)
for panel, points, title in zip(
    panels, (on_chord, sites), ("on straight chords", "as rods"), strict=True
):
    flat = points @ view.T
    for axis in found.design.axes:
        panel.plot(*(view @ np.stack([axis.begin, axis.end]).T * UNIT_NM), color="0.9", lw=22)
    for k, colour in enumerate(system.colour):
        own = np.flatnonzero(system.strand == k)
        panel.plot(*flat[own].T, color=colour, lw=1.2)
        laid = own[single[own]]
        panel.plot(*flat[laid].T, "o", color=colour, ms=4.5)
    panel.set_title(f"Single strands {title}", fontsize=10, loc="left")
    panel.set_aspect("equal")
    panel.set_ylabel("nm")
panels[-1].set_xlabel("nm")
figure.savefig("nanostructure.png", dpi=130, bbox_inches="tight")
