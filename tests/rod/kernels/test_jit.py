import subprocess
import sys

from loopelastica.rod.kernels.jit import driver, kernel


@kernel
def _doubled(x, n):
    for _ in range(n):
        x = 2.0 * x
    return x


@driver
def _eightfold(x):
    """Eight times ``x``."""
    return _doubled(x, 3)


@kernel
def _sixteenfold(x):
    return _eightfold(x) * 2.0


def test_a_kernel_is_compiled_once_whatever_constant_it_is_called_with():
    assert _sixteenfold(1.0) == 16.0
    assert _doubled(1.0, 3) == 8.0
    assert len(_doubled.signatures) == 1


def test_a_driver_is_the_same_from_python_and_from_a_kernel():
    assert _eightfold(1.0) == 8.0
    assert _eightfold.__doc__ == "Eight times ``x``."
    assert 2.0 * _eightfold(0.3) == _sixteenfold(0.3)


def test_compiling_is_said_once(tmp_path):
    said = subprocess.run(
        [
            sys.executable, "-c",
            "import logging; logging.basicConfig(level=logging.INFO)\n"
            "from loopelastica.rod.kernels import jit\n"
            "jit._PATIENCE_S = 0.05\n"
            "from loopelastica.rod.kernels.rotations import larger, wrap\n"
            "wrap(4.0); larger(1.0, 2.0)",
        ],
        env={"LOOPELASTICA_CACHE": str(tmp_path), "PATH": "", "PYTHONPATH": ":".join(sys.path)},
        capture_output=True, text=True, check=True,
    ).stderr  # fmt: skip
    assert said.count("compiling the solver") == 1
