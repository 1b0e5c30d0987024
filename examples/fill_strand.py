"""Fill a gap in a chain with all its atoms, and draw it: python examples/fill_strand.py"""

# %% A structure with a gap: the hairpin 2KOC (first model) without its loop, nucleotides 6 to 9
from pathlib import Path

import loopelastica as le

file = Path(__file__).resolve().parents[1] / "data" / "hairpins" / "2koc.pdb"
first_model = file.read_text().split("ENDMDL")[0].splitlines()
atoms = [line for line in first_model if line.startswith("ATOM") and line[76:78].strip() != "H"]
loop = [line for line in atoms if 6 <= int(line[22:26]) <= 9]
gapped = Path("gapped.pdb")
record = "\n".join(
    f"SEQRES{line:4d} A   14  " + " ".join(f"{letter:>3}" for letter in letters)
    for line, letters in enumerate(("GGCACUUCGGUGC", "C"), start=1)
)
there = [line for line in atoms if line not in loop]
gapped.write_text("\n".join([record, *there, "END", ""]))

# %% SEQRES says what is missing; without it `strands="A.6-9=UUCG"` would
filling = le.fill(gapped)
for strand in filling.strands:
    low, expected, high = strand.expected_rmsd_A
    print(f"{strand.name} {strand.sequence}: {strand.status}, sound: {strand.sound}")
    print(f"  error to expect {expected:.1f} Å, in 80 % of cases {low:.1f} to {high:.1f} Å")
print(filling.write("filled.pdb"))

# %% A picture: what was there, what was built, and the loop that was taken out
import matplotlib  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

BACKBONE = ("P", "O5'", "C5'", "C4'", "C3'", "O3'")


def backbone(lines, wanted):
    rows = [line for line in lines if line[12:16].strip() in BACKBONE and wanted(line)]
    return np.array([[float(line[k : k + 8]) for k in (30, 38, 46)] for line in rows])


def in_loop(line):
    return 6 <= int(line[22:26]) <= 9


filled = [line for line in Path("filled.pdb").read_text().splitlines() if line.startswith("ATOM")]
everything = backbone(filled, lambda line: True)
middle = everything.mean(axis=0)
up, across, depth = np.linalg.svd(everything - middle, full_matrices=False)[2]
figure, axes = plt.subplots(1, 2, figsize=(7.0, 5.0), sharey=True)
for view, sideways in zip(axes, (across, depth), strict=True):

    def draw(points, view=view, sideways=sideways, **style):
        view.plot((points - middle) @ sideways, (points - middle) @ up, **style)

    draw(backbone(filled, lambda line: int(line[22:26]) <= 5), color="0.6", lw=2, label="there")
    draw(backbone(filled, lambda line: int(line[22:26]) >= 10), color="0.6", lw=2)
    draw(backbone(loop, in_loop), color="#D55E00", lw=1.5, ls="--", label="taken out")
    draw(backbone(filled, in_loop), color="#0072B2", lw=2.5, label="built")
    view.set_aspect("equal")
    view.set_xlabel("Å")
axes[0].set_ylabel("Å")
axes[1].legend(loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
figure.suptitle("2KOC: nucleotides 6-9 between 5 and 10, not superposed", fontsize=10)
figure.savefig("fill_strand.png", dpi=130, bbox_inches="tight")
