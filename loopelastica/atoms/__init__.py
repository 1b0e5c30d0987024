"""Atoms on the line: from a folded rod to a complete loop in its structure.

The steps are those of biopolymer chain elasticity (Pakleza & Cognet, Nucleic Acids Res. 31 (2003)
1075): the ideal strand is carried onto the line (:mod:`.carry`), its nucleosides are turned about
it (:mod:`.turn`), and the chemistry (:mod:`.chemistry`, :mod:`.ideal`) is restored by least squares
(:mod:`.relax`, :mod:`.minimum`) with all that is there fixed; :mod:`.checks` measures the result.
:mod:`.search` repeats these steps until a model is sound. A :class:`.site.Site` is where it takes
them: :func:`.model.build_atoms` makes that of a hairpin, :func:`.strand.build_strand` that of any
gap. rdkit is imported when the first molecule is built, the compiled kernels when the first sum of
squares is minimized.
"""
