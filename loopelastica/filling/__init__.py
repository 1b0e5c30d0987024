"""Strands into structures: from what is missing to a file that the next program accepts.

:mod:`.fill` is the way: entry → gaps → lines (:mod:`loopelastica.folding.line`) → atoms
(:mod:`loopelastica.atoms`) → the entry with them in place (:mod:`loopelastica.report.compose`).
"""
