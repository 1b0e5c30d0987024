"""Print the oldest releases that pyproject.toml allows, as constraints for pip.

What is printed goes into a file: ``pip install -c oldest.txt -e '.[dev]'``.
"""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
extras = project.get("optional-dependencies", {}).values()
for line in [*project["dependencies"], *(line for lines in extras for line in lines)]:
    found = re.match(r"([A-Za-z0-9._-]+)\s*>=\s*([0-9][0-9.]*)", line)
    if found:
        print(f"{found[1]}=={found[2]}")
