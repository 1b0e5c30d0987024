import sys
from pathlib import Path

# the strands that several tests cut out
sys.path.insert(0, str(Path(__file__).parent))
