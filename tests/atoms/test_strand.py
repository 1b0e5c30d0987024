from dataclasses import replace

import numpy as np
import pytest
from cut_strands import (
    PHOSPHATE,
    base,
    cut,
    heavy,
    ideal_line,
    left,
    monomers,
    only,
    without,
)
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from loopelastica.atoms.hairpin import ideal_hairpin
from loopelastica.atoms.sequence import read_sequence
from loopelastica.atoms.strand import WATER_A, build_strand, complete_nucleotide
from loopelastica.errors import StructureError
from loopelastica.molecule.nucleotides import BACKBONE

pytest.importorskip("rdkit")


@pytest.fixture(scope="module")
def rna(koc):
    """2KOC: 14 nucleotides, a stem and UUCG."""
    return monomers(koc)


@pytest.fixture(scope="module")
def dna():
    """Ten nucleotides of an ideal B strand: the first half of a stem."""
    structure, _, _ = ideal_hairpin(read_sequence("GCGAATCTGC(TTT)GCAGATTCGC"))
    return monomers(structure)[:10]


def filled(chain, gap, *others, **options):
    return build_strand(gap, ideal_line(gap), heavy(left(chain, gap), *others), **options)


def judged(model, chain, gap):
    """Oracle: distances of the built atoms, from nothing but names and positions."""
    built = model.built
    at = {key: model.positions_A[row] for key, row in model.molecule.rows.items()}
    for k in range(len(gap) + 1):
        bond = np.linalg.norm(at[k - 1, "O3'"] - at[k, "P"])
        assert bond == pytest.approx(1.607, abs=0.05)
    flanks = {gap.before.label, gap.after.label}
    rest = heavy([monomer for monomer in left(chain, gap) if monomer.label not in flanks])
    assert cdist(model.positions_A[built], rest.positions_A).min() >= 2.2


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_a_strand_cut_out_of_a_stem_is_filled_with_sound_atoms(rna, n):
    gap = cut(rna, 2, n)
    model = filled(rna, gap)
    assert model.checks.wrong == ()
    assert model.checks.sound
    assert model.checks.worst_angle_deg <= 10.0
    assert model.checks.status == "converged"
    judged(model, rna, gap)
    native = np.array([[m.atoms_A[x] for x in BACKBONE] for m in rna[2 : 2 + n]]).mean(axis=1)
    rows = [[model.molecule.index(k, name) for name in BACKBONE] for k in range(n)]
    own = model.positions_A[np.array(rows)].mean(axis=1)
    # the line is the ideal strand, the stem is nearly one
    assert np.sqrt(((own - native) ** 2).sum(axis=1).mean()) < 2.0


def test_dna_is_filled_too(dna):
    model = filled(dna, cut(dna, 1, 2))
    assert model.checks.sound
    names = {name for (k, name) in model.molecule.rows if k == 0}
    assert "O2'" not in names


def test_a_strand_may_be_of_both_kinds(rna):
    gap = cut(rna, 2, 2)
    mixed = replace(gap.monomers[1], is_dna=True, resname="DA", letter="A")
    gap = replace(gap, monomers=(gap.monomers[0], mixed))
    model = filled(rna, gap)
    assert model.checks.sound
    assert (0, "O2'") in model.molecule.rows
    assert (1, "O2'") not in model.molecule.rows
    assert [residue.kind.standard for residue in model.residues] == [rna[2].resname, "DA"]


FLANKS = {
    "3' flank without its phosphate": lambda g: replace(g, after=without(g.after, *PHOSPHATE)),
    "3' flank without P and O5'": lambda g: replace(g, after=without(g.after, *PHOSPHATE, "O5'")),
    "3' flank without free oxygens": lambda g: replace(g, after=without(g.after, "OP1", "OP2")),
    "5' flank without O3'": lambda g: replace(g, before=without(g.before, "O3'")),
    "5' flank without its phosphate": lambda g: replace(g, before=without(g.before, *PHOSPHATE)),
    "5' flank without its base": lambda g: replace(g, before=without(g.before, *base(g.before))),
    "3' flank without its base": lambda g: replace(g, after=without(g.after, *base(g.after))),
}


@pytest.mark.parametrize("case", FLANKS)
def test_what_a_flank_lacks_is_built_and_what_it_has_stays_to_the_digit(rna, case):
    gap = FLANKS[case](cut(rna, 3, 2))
    model = filled(rna, gap)
    assert model.checks.wrong == ()
    whole = cut(rna, 3, 2)
    for k, flank, before in ((-1, gap.before, whole.before), (2, gap.after, whole.after)):
        for name in before.atoms_A:
            row = model.molecule.index(k, name)
            assert model.built[row] == (name not in flank.atoms_A)
            if name in flank.atoms_A:
                np.testing.assert_array_equal(model.positions_A[row], flank.atoms_A[name])


MONOMERS = {
    "only a phosphate": lambda m: only(m, *PHOSPHATE),
    "only P and O5'": lambda m: only(m, "P", "OP1", "OP2", "O5'"),
    "no base": lambda m: without(m, *base(m)),
    "only a base": lambda m: only(m, *base(m)),
    "one atom": lambda m: only(m, "C4'"),
}


@pytest.mark.parametrize("case", MONOMERS)
def test_atoms_of_the_strand_that_are_there_are_kept(rna, case):
    gap = cut(rna, 3, 2)
    part = MONOMERS[case](rna[3])
    gap = replace(gap, monomers=(part, gap.monomers[1]))
    model = filled(rna, gap)
    assert model.checks.wrong == ()
    for name, at in part.atoms_A.items():
        row = model.molecule.index(0, name)
        assert not model.built[row]
        np.testing.assert_array_equal(model.positions_A[row], at)
    assert all(set(residue.names).isdisjoint(residue.monomer.atoms_A) for residue in model.residues)


def test_modified_nucleotides_are_built_as_far_as_they_are_known(rna):
    gap = cut(rna, 3, 2)
    names = (("5MU", "U"), ("PSU", "U"))
    renamed = [
        replace(monomer, resname=resname, letter=letter)
        for monomer, (resname, letter) in zip(gap.monomers, names, strict=True)
    ]
    model = filled(rna, replace(gap, monomers=tuple(renamed)))
    assert model.checks.wrong == ()
    assert [residue.kind.standard for residue in model.residues] == ["5MU", "U"]
    assert "C5M" in model.residues[0].names


def test_what_a_modified_flank_lacks_of_its_base_is_left_and_its_own_groups_are_no_contacts(rna):
    gap = cut(rna, 3, 2)
    o3 = gap.before.atoms_A["O3'"]
    c3 = gap.before.atoms_A["C3'"]
    group = {"X1": c3 + 1.5 * (c3 - o3) / np.linalg.norm(c3 - o3)}
    kept = without(gap.before, *base(gap.before), "O3'").atoms_A
    odd = replace(gap.before, resname="XYZ", letter="N", atoms_A={**kept, **group})
    model = filled(rna, replace(gap, before=odd))
    assert model.checks.wrong == ()
    assert {r.monomer.label: r.names for r in model.residues}["A.XYZ3"] == ("O3'",)


def test_no_phosphate_is_invented_at_a_5_end(rna):
    chain = [without(rna[0], *PHOSPHATE), *rna[1:]]
    model = filled(chain, cut(chain, 1, 2))
    assert model.checks.sound
    assert (-1, "P") not in model.molecule.rows
    # where a nucleotide is bonded to it, the phosphate is missing and is built
    chain = [rna[0], without(rna[1], *PHOSPHATE), *rna[2:]]
    model = filled(chain, cut(chain, 2, 2))
    assert model.built[model.molecule.index(-1, "P")]
    assert model.checks.sound


def test_a_nucleotide_beside_no_gap_is_completed(rna):
    part = without(rna[4], *base(rna[4]))
    rest = heavy([*rna[:4], part, *rna[5:]])
    model = complete_nucleotide(part, rest, before=rna[3], after=rna[5])
    assert model.checks.wrong == ()
    assert {name for residue in model.residues for name in residue.names} == set(base(rna[4]))
    # at an end of its chain, where it needs no phosphate
    first = without(rna[0], *PHOSPHATE, "O2'", *base(rna[0]))
    model = complete_nucleotide(first, heavy([first, *rna[1:]]), after=rna[1])
    assert model.checks.wrong == ()
    assert (0, "P") not in model.molecule.rows
    with pytest.raises(StructureError, match="cannot be completed"):
        complete_nucleotide(only(rna[4], "P"), rest, before=rna[3], after=rna[5])
    with pytest.raises(StructureError, match="no atom is missing"):
        complete_nucleotide(rna[4], heavy(rna), before=rna[3], after=rna[5])


def test_waters_give_way_and_metals_may_be_coordinated(rna):
    gap = cut(rna, 3, 2)
    free = filled(rna, gap)
    spot = free.positions_A[free.molecule.index(0, "OP1")]
    water = filled(rna, gap, ("HOH", "O", spot + [0.0, 0.0, 0.5]))
    np.testing.assert_array_equal(water.positions_A, free.positions_A)
    places = heavy(left(rna, gap), ("HOH", "O", spot + [0.0, 0.0, 0.5])).positions_A[water.waters]
    assert len(places) == 1
    assert cdist(places, water.positions_A[water.built]).min() < WATER_A
    assert free.waters.size == 0
    p = free.positions_A[free.molecule.index(0, "P")]
    metal_A = spot + 2.0 * (spot - p) / np.linalg.norm(spot - p)
    metal = filled(rna, gap, ("MG", "MG", metal_A))
    assert metal.checks.sound
    away = np.linalg.norm(metal.positions_A[metal.built] - metal_A, axis=1)
    assert away.min() >= 1.9
    # any other atom in the same place is avoided
    other = filled(rna, gap, ("ZZZ", "C", metal_A))
    assert other.checks.sound
    assert np.linalg.norm(other.positions_A[other.built] - metal_A, axis=1).min() >= 2.2


def test_a_rigid_motion_of_everything_moves_the_atoms_and_nothing_else(rna, rng):
    turn = Rotation.random(random_state=rng).as_matrix()
    shift = rng.uniform(-80, 80, 3)

    def moved(monomer):
        return replace(monomer, atoms_A={k: turn @ at + shift for k, at in monomer.atoms_A.items()})

    here = filled(rna, cut(rna, 3, 3))
    elsewhere = [moved(monomer) for monomer in rna]
    there = filled(elsewhere, cut(elsewhere, 3, 3))
    np.testing.assert_allclose(here.positions_A @ turn.T + shift, there.positions_A, atol=1e-4)


def test_where_there_is_no_room_the_least_bad_model_comes_back_and_says_what_is_wrong(rna):
    gap = cut(rna, 3, 2)
    # a wall of atoms across the gap, closer than anything could pass
    middle = 0.5 * (gap.before.atoms_A["O3'"] + gap.after.atoms_A["P"])
    along = gap.after.atoms_A["P"] - gap.before.atoms_A["O3'"]
    along /= np.linalg.norm(along)
    u = np.cross(along, [0.3, 0.5, 0.8])
    u /= np.linalg.norm(u)
    v = np.cross(along, u)
    steps = np.arange(-12.0, 13.0, 1.5)
    wall = [("WAL", "C", middle + a * u + b * v) for a in steps for b in steps]
    model = filled(rna, gap, *wall, max_seconds=2.0)
    assert not model.checks.sound
    assert any("Å apart" in phrase or "off by" in phrase for phrase in model.checks.wrong)
    assert np.isfinite(model.positions_A).all()
    assert "not sound" in repr(model)


def test_a_limit_of_steps_is_no_soundness(rna):
    model = filled(rna, cut(rna, 3, 2), max_steps=3, max_seconds=2.0)
    assert not model.checks.sound
    assert "the limit of steps was reached" in model.checks.wrong


def test_an_unknown_base_and_impossible_options_are_refused(rna):
    gap = cut(rna, 3, 2)
    unknown = replace(gap.monomers[0], letter="N", resname="N")
    with pytest.raises(StructureError, match=r"A\.N4: its base is unknown"):
        filled(rna, replace(gap, monomers=(unknown, gap.monomers[1])))
    for name, value in (("tries", 0), ("max_steps", 0), ("max_seconds", 0), ("contact", "x")):
        with pytest.raises(ValueError, match=f"`{name}`"):
            filled(rna, gap, **{name: value})


@pytest.mark.slow
@pytest.mark.parametrize("n", [8, 12, 40])
def test_long_strands_work(rna, n):
    """Laid on a straight helix that leaves the structure."""
    letters = (rna * 4)[:n]
    empty = tuple(replace(m, atoms_A={}, number=100 + k) for k, m in enumerate(letters))
    gap = cut(rna, 3, 1)
    line = ideal_line(gap)
    rotation, shift = _screw(line, n)
    far = replace(
        rna[4], atoms_A={k: rotation @ at + shift for k, at in rna[4].atoms_A.items()}, number=999
    )
    gap = replace(gap, monomers=empty, after=far, beyond_3=None)
    model = build_strand(gap, line, heavy([*rna[:3], far]), max_seconds=60.0)
    assert model.checks.wrong == ()


def _screw(line, n):
    """The motion that carries phase 2 of the line to phase n + 1."""
    points, frames = line.at([2.0, n + 1.0])
    rotation = frames[1] @ frames[0].T
    return rotation, points[1] - rotation @ points[0]
