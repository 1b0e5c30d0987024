"""What a result is written and shown as: folders, tables, PDB records, viewers' scripts, plots."""
