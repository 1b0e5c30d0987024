"""Single strands of DNA nanostructures: between helices of a design, in the units of oxDNA."""
