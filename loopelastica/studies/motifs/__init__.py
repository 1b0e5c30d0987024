"""The numbers of ``data/motifs.json`` and ``data/loops.lib``, and how good they are."""
