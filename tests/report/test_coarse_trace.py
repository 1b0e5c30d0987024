"""A nanostructure for viewers: what they read is what was laid."""

import json

import gemmi
import helix_designs as designs
import MDAnalysis as mda
import numpy as np
import pytest

from loopelastica.nanostructures.oxdna.model import UNIT_NM, backbone_sites
from loopelastica.report.coarse_trace import (
    chain_name,
    mmcif_text,
    oxview_text,
    pdb_text,
    pymol_text,
    trace,
)

sc = designs.sc


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Two helices, a linker, a hairpin and a tail; three colours."""
    from loopelastica.nanostructures.nanostructure import nanostructure

    design = sc.Design(helices=[sc.Helix(max_offset=64) for _ in range(2)], grid=sc.square)
    strand = design.draw_strand(0, 0).move(21).loopout(1, 14).move(-21)
    strand.with_color(sc.Color(255, 0, 0))
    design.draw_strand(0, 21).move(-21).extension_3p(9).with_color(sc.Color(0, 120, 255))
    design.draw_strand(1, 0).move(32).loopout(1, 5).move(-11).with_color(sc.Color(0, 160, 60))
    return nanostructure(designs.write(design, tmp_path_factory.mktemp("design")))


def sites_A(found):
    system = found.system
    return 10 * UNIT_NM * backbone_sites(system.centre, system.a1, system.a3)


def test_chains_have_names_of_their_own():
    names = [chain_name(i) for i in range(70_000)]
    assert len(set(names)) == len(names)
    assert all(len(name) == 1 for name in names[:62])
    assert all(name.isalnum() and name.isascii() for name in names)


def test_pdb_has_an_atom_p_at_each_backbone_site(found, tmp_path):
    (tmp_path / "a.pdb").write_text(pdb_text(trace(found)))
    atoms = mda.Universe(str(tmp_path / "a.pdb")).atoms
    np.testing.assert_allclose(atoms.positions, sites_A(found), atol=6e-4)
    assert set(atoms.names) == {"P"}
    assert atoms.resnames.tolist() == [f"D{base}" for base in found.system.base]
    expected = [chain_name(k) for k in found.system.strand]
    assert atoms.chainIDs.tolist() == expected
    single = found.system.pair < 0
    np.testing.assert_array_equal(atoms.tempfactors, np.where(single, 100.0, 0.0))


def test_mmcif_has_the_same_atoms(found):
    block = gemmi.cif.read_string(mmcif_text(trace(found))).sole_block()
    read = gemmi.make_structure_from_block(block)
    atoms = [cra.atom for cra in read[0].all()]
    np.testing.assert_allclose([a.pos.tolist() for a in atoms], sites_A(found), atol=6e-4)
    assert [chain.name for chain in read[0]] == ["A", "B", "C"]
    numbers = [residue.seqid.num for residue in read[0]["A"]]
    assert numbers == list(range(1, 57))


def test_pdb_is_left_out_where_it_does_not_hold_the_strands(tmp_path):
    from loopelastica.nanostructures.nanostructure import nanostructure

    many = nanostructure(designs.write(designs.hairpins(63), tmp_path))
    assert pdb_text(trace(many)) is None
    read = gemmi.make_structure_from_block(
        gemmi.cif.read_string(mmcif_text(trace(many))).sole_block()
    )
    assert [chain.name for chain in read[0]][-2:] == ["9", "AA"]
    many.write(tmp_path / "out")
    assert not (tmp_path / "out" / "design.pdb").exists()
    assert (tmp_path / "out" / "design.cif").exists()


def test_pymol_gets_the_colours_of_the_design(found):
    lines = pymol_text(found, "a.cif").splitlines()
    assert "load a.cif, trace" in lines
    for chain, colour in (("A", "ff0000"), ("B", "0078ff"), ("C", "00a03c")):
        assert f"color 0x{colour}, chain {chain}" in lines


def test_oxview_gets_places_pairs_and_colours(found):
    n = len(found.system)
    # numbers of monomers are lines of a configuration that has another order
    line = np.arange(n)[::-1]
    content = json.loads(oxview_text(found, line))
    (system,) = content["systems"]
    monomers = {m["id"]: m for strand in system["strands"] for m in strand["monomers"]}
    assert sorted(monomers) == list(range(n))
    number = np.append(line, -1)
    for i, monomer in ((n - 1 - k, monomer) for k, monomer in monomers.items()):
        np.testing.assert_allclose(monomer["p"], found.system.centre[i], atol=1e-8)
        np.testing.assert_allclose(monomer["a1"], found.system.a1[i], atol=1e-8)
        assert monomer.get("bp", -1) == number[found.system.pair[i]]
        assert monomer.get("n3", -1) == number[found.system.n3[i]]
    assert [strand["monomers"][0]["color"] for strand in system["strands"]] == [
        0xFF0000,
        0x0078FF,
        0x00A03C,
    ]
    for strand in system["strands"]:
        assert "n5" not in monomers[strand["end5"]]
        assert "n3" not in monomers[strand["end3"]]
