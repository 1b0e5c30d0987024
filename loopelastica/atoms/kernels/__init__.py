"""Compiled kernels of the atoms: sums of squares and their minimization, tables of clashes."""
