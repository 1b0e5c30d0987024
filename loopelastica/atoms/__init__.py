"""Atoms on the line: from a folded rod to a complete loop in its structure.

The steps are those of biopolymer chain elasticity (Pakleza & Cognet, Nucleic Acids Res. 31 (2003)
1075): the ideal strand is carried onto the line (:mod:`.carry`), its nucleosides are turned about
it (:mod:`.turn`), and the chemistry (:mod:`.chemistry`, :mod:`.ideal`) is restored by least squares
(:mod:`.relax`) with the stem fixed. :func:`.model.build_atoms` takes these steps, and
:mod:`.checks` measures the result. rdkit is imported when the first molecule is built.
"""
