"""Compiled code of the rod: plain arrays in, tuples out, no exception, no knowledge of objects."""
