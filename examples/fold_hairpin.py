"""Fold the loop of an NMR hairpin and draw it: python examples/fold_hairpin.py"""

# %% Fold every hairpin loop of the file: here one, the UUCG loop of 2KOC
from pathlib import Path

import loopelastica as le

file = Path(__file__).resolve().parents[1] / "data" / "hairpins" / "2koc.pdb"
(loop,) = le.fold(file)
print(loop.hairpin.sequence, "closed by", *loop.hairpin.closing_pair)

# %% The candidates: least deformation energy first, shapes that touch something last
for candidate in loop.candidates:
    print(
        f"{candidate.rank}: E/K0 {candidate.energy_per_A:.3f} 1/Å,"
        f" RMSD to the file's loop {candidate.rmsd_A:.2f} Å"
    )

# %% Where the first one puts the backbone of each loop nucleotide, in the file's coordinates
for residue, point in zip(loop.hairpin.residues, loop.candidates[0].trace, strict=True):
    print(residue, point.round(1))

# %% A picture
from loopelastica.report.plots import plot_fold  # noqa: E402

plot_fold(loop, Path("fold_hairpin.png"), title="2koc")
