"""Nucleic acids into clamped lines: lengths in Å, coordinates of the file.

Atoms are read once into :class:`~loopelastica.molecule.nucleotides.Nucleotides` (names to indices);
everything after that is arrays of positions, one model at a time.
"""
