"""Build hook: the wheel carries the solver compiled for any processor of its architecture.

Where compiling fails, or ``LOOPELASTICA_PURE_WHEEL`` is set, the wheel is a pure one and the solver
is compiled at its first use.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CompiledKernels(BuildHookInterface):
    """Compiles the kernels of all rooms from the sources and adds what that leaves behind."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile before the wheel is put together."""
        if self.target_name != "wheel" or os.environ.get("LOOPELASTICA_PURE_WHEEL"):
            return
        root = Path(self.root)
        editable = version == "editable"
        place = root / "loopelastica" / "_compiled" if editable else Path(tempfile.mkdtemp())
        # the kernels' own module says for which processor
        sys.path.insert(0, str(root))
        try:
            from loopelastica.rod.kernels.portable import portable_environment

            environment = {
                **os.environ,
                **portable_environment(),
                "LOOPELASTICA_CACHE": str(place),
                "PYTHONPATH": os.pathsep.join([str(root), *sys.path]),
            }
            commands = [
                [sys.executable, "-m", "loopelastica.rod.warm", "--solver-only"],
                [sys.executable, "-m", "loopelastica.atoms.warm"],
            ]
            # side by side: the wall time is that of the rod
            running = [subprocess.Popen(command, env=environment, cwd=root) for command in commands]
            for process in running:
                if process.wait():
                    raise subprocess.CalledProcessError(process.returncode, process.args)
        except (ImportError, OSError, subprocess.CalledProcessError) as error:
            self.app.display_warning(f"the solver is compiled at its first use: {error}")
            return
        finally:
            sys.path.remove(str(root))
        if editable:
            return
        self._scratch = place
        build_data["force_include"][str(place)] = "loopelastica/_compiled"
        build_data["pure_python"] = False
        build_data["infer_tag"] = True

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what was compiled for the wheel."""
        shutil.rmtree(getattr(self, "_scratch", ""), ignore_errors=True)
