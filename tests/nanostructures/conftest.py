import sys
from pathlib import Path

# what several modules of this folder use: systems, and LAMMPS as an oracle
sys.path.insert(0, str(Path(__file__).parent))
