"""Strands that are there, taken out and filled again: how near, how sound, how fast."""
