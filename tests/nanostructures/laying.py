"""Designs that several tests lay, and what a start must fulfil."""

import helix_designs as designs
import numpy as np

from loopelastica.nanostructures.oxdna.checks import check_start
from loopelastica.nanostructures.oxdna.energies import bonds, excluded_volume
from loopelastica.nanostructures.oxdna.model import BOND_LONGEST, BOND_SHORTEST

sc = designs.sc
# crossovers between relaxed helices are within the window of bonds
FITTING = {"bases_per_turn": 32 / 3, "inter_helix_gap": 0.1}


def hairpins(lengths, stem=16):
    """A hairpin on each helix."""
    design = designs.row_of(len(lengths), stem, **FITTING)
    for k, length in enumerate(lengths):
        design.draw_strand(k, 0).move(stem).loopout(k, length).move(-stem)
    return design


def linker(apart, length, stem=21):
    """A linker between two helices; those between them are twice as long."""
    design = designs.row_of(apart + 1, 2 * stem, **FITTING)
    design.draw_strand(0, 0).move(stem).loopout(apart, length).move(-stem)
    design.draw_strand(0, stem).move(-stem)
    design.draw_strand(apart, 0).move(stem)
    for k in range(1, apart):
        design.draw_strand(k, 0).move(2 * stem)
        design.draw_strand(k, 2 * stem).move(-2 * stem)
    design.relax_helix_rolls()
    return design


def pairs(count, length, stem=16):
    """Pairs of helices far from each other, each with a linker."""
    helices = [
        sc.Helix(max_offset=stem, position=sc.Position3D(k % 2 * 2.1, k // 2 * 15.0, 0))
        for k in range(2 * count)
    ]
    design = sc.Design(helices=helices, grid=sc.Grid.none, geometry=sc.Geometry(**FITTING))
    for k in range(count):
        design.draw_strand(2 * k, 0).move(stem).loopout(2 * k + 1, length).move(-stem)
    for k in range(count):
        design.draw_strand(2 * k, stem).move(-stem)
        design.draw_strand(2 * k + 1, 0).move(stem)
    return design


def tailed(five, three, stem=24):
    """Two helices, each with a nick, and with tails at all ends of strands."""
    design = designs.row_of(2, stem, **FITTING)
    half = stem // 2
    for k in range(2):
        design.draw_strand(k, 0).extension_5p(five).move(stem).extension_3p(three)
        design.draw_strand(k, stem).move(-half).extension_3p(three)
        design.draw_strand(k, half).extension_5p(five).move(-half)
    return design


def assert_starts(system, laid):
    """Bonds, distances and axes of laid strands are such that a simulation can start."""
    found = check_start(system)
    for faults in (found.broken, found.close):
        assert not laid[faults].any(), found.sentences()
    bonded = bonds(system)
    own = laid[bonded.first] | laid[bonded.second]
    assert own.any()
    assert (bonded.length[own] > BOND_SHORTEST + 0.01).all()
    assert (bonded.length[own] < BOND_LONGEST - 0.01).all()
    axes = np.stack([system.a1, system.a2, system.a3], axis=1)[laid]
    gram = axes @ axes.transpose(0, 2, 1)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), gram.shape), atol=1e-12)
    volume = excluded_volume(system)
    near = laid[volume.first] | laid[volume.second]
    # kT at 300 K is 0.1
    assert volume.energy[near].max(initial=0.0) < 0.5
    assert bonded.excluded_volume[own].max() < 0.5
