"""Starts of simulations of nanostructures: rods, straight chords, arcs and an exporter."""
