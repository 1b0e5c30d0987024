"""Fill a gap in a chain with all its atoms, and draw it: python examples/fill_strand.py"""

# %% A structure with a gap: the hairpin 2KOC (first model) without its loop, nucleotides 6 to 9
from pathlib import Path

import loopelastica as le

file = Path(__file__).resolve().parents[1] / "data" / "hairpins" / "2koc.pdb"
first_model = file.read_text().split("ENDMDL")[0].splitlines()
atoms = [line for line in first_model if line.startswith("ATOM") and line[76:78].strip() != "H"]
loop = [line for line in atoms if 6 <= int(line[22:26]) <= 9]
gapped = Path("gapped.pdb")
gapped.write_text(
    "SEQRES   1 A   14    G   G   C   A   C   U   U   C   G   G   U   G   C   C\n"
    + "\n".join(line for line in atoms if line not in loop)
    + "\nEND\n"
)

# %% What is missing is found by the sequence of record (SEQRES); `strands="A.6-9=UUCG"` would give it
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
figure, axes = plt.subplots(1, 2, figsize=(8.0, 4.2), subplot_kw={"projection": "3d"})
for view, azimuth in zip(axes, (20.0, 110.0), strict=True):
    for strand, wanted in (
        ("there", lambda line: int(line[22:26]) <= 5),
        (None, lambda line: int(line[22:26]) >= 10),
    ):
        view.plot(*backbone(filled, wanted).T, color="0.6", lw=2, label=strand)
    view.plot(*backbone(filled, in_loop).T, color="#0072B2", lw=3, label="built")
    view.plot(*backbone(loop, in_loop).T, color="#D55E00", lw=1.5, ls="--", label="taken out")
    view.set_box_aspect([np.ptp(axis) for axis in backbone(filled, lambda line: True).T])
    view.view_init(elev=10.0, azim=azimuth)
    view.set_axis_off()
axes[0].legend(loc="upper left", frameon=False)
figure.suptitle("2KOC, nucleotides 6-9 filled between 5 and 10; no superposition")
figure.savefig("fill_strand.png", dpi=130, bbox_inches="tight")
