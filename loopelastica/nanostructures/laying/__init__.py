"""Single strands between helices: rods, tails and samples, clear of what is there."""
