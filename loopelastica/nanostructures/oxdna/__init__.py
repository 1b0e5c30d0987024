"""The model of oxDNA and its files: sites, energies, pairs, checks of a start."""
