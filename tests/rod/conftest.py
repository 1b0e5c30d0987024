import sys
from pathlib import Path

# the random rods that several tests draw
sys.path.insert(0, str(Path(__file__).parent))
