"""Files that come with the package, to try things on.

    from loopelastica.datafiles import RNA_2KOC

The structures are entries of the Protein Data Bank as deposited; its data are free of copyright
(CC0).
"""

from typing import Final

from loopelastica._files import data_path

__all__ = ["LOOPS", "RNA_1Y26", "RNA_2KOC", "RNA_4GXY", "RNA_430D"]

RNA_1Y26: Final = str(data_path("hairpins/1y26.pdb.gz"))
"""Adenine riboswitch, X-ray; its two hairpin loops kiss each other."""

RNA_2KOC: Final = str(data_path("hairpins/2koc.pdb"))
"""Hairpin with a UUCG loop, 20 models by NMR."""

RNA_430D: Final = str(data_path("hairpins/430d.pdb.gz"))
"""Sarcin/ricin loop of rat 28S rRNA, X-ray; a GAGA loop."""

RNA_4GXY: Final = str(data_path("hairpins/4gxy.pdb.gz"))
"""Adenosylcobalamin riboswitch, X-ray; two stretches of nucleotides were not observed."""

LOOPS: Final = str(data_path("loops.lib"))
"""Library of hairpin loops that :func:`loopelastica.fold` uses by default."""
