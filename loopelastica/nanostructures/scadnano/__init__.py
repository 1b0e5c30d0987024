"""Designs of scadnano as systems: what is drawn, where its helices and nucleotides are."""
