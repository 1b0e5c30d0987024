import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numba
import pytest

import loopelastica
from loopelastica.rod.kernels import jit, portable
from loopelastica.rod.kernels.jit import kernel

ROOT = Path(loopelastica.__file__).resolve().parents[1]

# calls a kernel of another module, and counts what had to be compiled
HINGE = """
from numba.core import event
with event.install_recorder("numba:compile") as compiled:
    import numpy as np
    from loopelastica.rod.kernels.discrete_rod import hinge_vector
    out = np.empty(3)
    hinge_vector(np.array([1.0, 0, 0, 0]), np.array([0.8, 0.6, 0, 0]), out)
print(len(compiled.buffer), *out)
"""


def run(code, tmp_path, package=ROOT, check=True, **environment):
    """A fresh process: its standard output and error."""
    known = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    settings = {"LOOPELASTICA_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(package)}
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], env=known | settings | environment, cwd=tmp_path,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert not check or done.returncode == 0, done.stderr
    return done.stdout, done.stderr


def compiled_and_value(stdout):
    count, *values = stdout.split()
    return int(count), [float(value) for value in values]


def copied(folder):
    """A copy of the package that has no compiled code."""
    ignored = shutil.ignore_patterns("__pycache__", "_compiled")
    shutil.copytree(ROOT / "loopelastica", folder / "loopelastica", ignore=ignored)
    return folder


@pytest.fixture
def package(tmp_path):
    """A copy of the package that has no compiled code, to be edited."""
    return copied(tmp_path / "copy")


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Where a package of this text was run for the first time, and what it printed."""
    folder = tmp_path_factory.mktemp("ran")
    return folder, run(HINGE, folder, copied(folder / "copy"))[0]


@pytest.fixture
def before(ran, tmp_path):
    """What was computed there; the compiled code is here now."""
    folder, printed = ran
    shutil.copytree(folder / "cache", tmp_path / "cache")
    compiled, value = compiled_and_value(printed)
    assert compiled > 0
    return value


@kernel
def _doubled(x, n):
    for _ in range(n):
        x = 2.0 * x
    return x


@kernel
def _halved(x):
    return 0.5 * x


@kernel
def _quadrupled(x):
    return _doubled(_halved(_doubled(x, 2)), 1)


@kernel
def _sixteenfold(x):
    return _halved(_quadrupled(x)) * _doubled(1.0, 3)


def test_a_kernel_is_compiled_once_whatever_constant_it_is_called_with():
    assert _sixteenfold(1.0) == 16.0
    assert _doubled(1.0, 3) == 8.0
    assert len(_doubled.signatures) == 1


def test_what_several_kernels_call_is_linked_into_each():
    assert _quadrupled(3.0) == 12.0
    assert _sixteenfold(3.0) == 48.0
    assert _halved(3.0) == 1.5


def test_an_edited_kernel_is_compiled_anew_with_all_that_call_it(package, tmp_path, before):
    assert before == pytest.approx([2.0 * 0.6435011087932844, 0.0, 0.0])
    again, same = compiled_and_value(run(HINGE, tmp_path, package)[0])
    assert (again, same) == (0, before)
    rotations = package / "loopelastica" / "rod" / "kernels" / "rotations.py"
    text = rotations.read_text()
    assert text.count("    return factor * x, factor * y, factor * z") == 1
    rotations.write_text(text.replace("return factor * x,", "return 2.0 * factor * x,"))
    compiled, after = compiled_and_value(run(HINGE, tmp_path, package)[0])
    assert compiled > 0
    assert after == pytest.approx([2.0 * before[0], 0.0, 0.0])


@pytest.mark.slow
@pytest.mark.usefixtures("before")
def test_another_version_of_the_package_has_code_of_its_own(package, tmp_path):
    version = package / "loopelastica" / "_version.py"
    version.write_text(version.read_text().replace("0.", "7.", 1))
    assert compiled_and_value(run(HINGE, tmp_path, package)[0])[0] > 0


@pytest.mark.slow
def test_a_damaged_file_is_made_anew(package, tmp_path, before):
    (file,) = (tmp_path / "cache").rglob("*.bin")
    whole = file.read_bytes()
    for damaged in (whole[: len(whole) // 2], whole[:-1] + b"x"):
        file.write_bytes(damaged)
        compiled, after = compiled_and_value(run(HINGE, tmp_path, package)[0])
        assert compiled > 0
        assert after == before
        assert compiled_and_value(run(HINGE, tmp_path, package)[0])[0] == 0


def test_where_nothing_can_be_written_code_stays_in_memory_and_that_is_said_once(package, tmp_path):
    (tmp_path / "file").touch()
    nowhere = str(tmp_path / "file" / "cache")
    twice = HINGE + "from loopelastica.rod.kernels.rotations import wrap\nwrap(4.0)\n"
    stdout, stderr = run(twice, tmp_path, package, LOOPELASTICA_CACHE=nowhere)
    compiled, value = compiled_and_value(stdout)
    assert compiled > 0
    assert value == pytest.approx([1.2870022175865687, 0.0, 0.0])
    assert stderr.count("cannot be kept") == 1
    assert nowhere in stderr


@pytest.mark.slow
def test_shipped_code_is_read_where_nothing_can_be_written(package, tmp_path):
    run(HINGE, tmp_path, package, **portable.portable_environment())
    shutil.copytree(tmp_path / "cache", package / "loopelastica" / "_compiled")
    (tmp_path / "file").touch()
    stdout, stderr = run(
        HINGE, tmp_path, package, LOOPELASTICA_CACHE=str(tmp_path / "file" / "cache")
    )
    assert compiled_and_value(stdout)[0] == 0
    assert not stderr


@pytest.mark.slow
@pytest.mark.usefixtures("before")
def test_a_checkout_reads_the_code_of_an_installation_of_the_same_text(package, tmp_path):
    installed = tmp_path / "site"
    shutil.copytree(package / "loopelastica", installed / "loopelastica")
    (tmp_path / "cache").rename(installed / "loopelastica" / "_compiled")
    path = os.pathsep.join([str(package), str(installed)])
    assert compiled_and_value(run(HINGE, tmp_path, path)[0])[0] == 0
    kernels = package / "loopelastica" / "rod" / "kernels"
    (kernels / "cubic.py").write_text((kernels / "cubic.py").read_text() + "\n# edited\n")
    assert compiled_and_value(run(HINGE, tmp_path, path)[0])[0] > 0


@pytest.mark.slow
def test_portable_code_runs_on_other_processors(package, tmp_path):
    if not portable.portable_environment():
        pytest.skip("no portable processor is known for this architecture")
    _, before = compiled_and_value(
        run(HINGE, tmp_path, package, **portable.portable_environment())[0]
    )
    # a processor of another name and other features than the code was compiled for
    other = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    for environment in ({}, other):
        assert compiled_and_value(run(HINGE, tmp_path, package, **environment)[0]) == (0, before)


@pytest.mark.slow
def test_whoever_waits_is_told_why_once_without_configuring_anything(package, tmp_path):
    impatient = "from loopelastica.rod.kernels import jit\njit._PATIENCE_S = 0.0\n" + HINGE
    _, stderr = run(impatient, tmp_path, package)
    assert stderr.count("compiling the solver") == 1
    _, stderr = run(impatient, tmp_path, package)
    assert not stderr


@pytest.mark.slow
def test_of_several_workers_one_says_it(package, tmp_path):
    workers = (
        "import multiprocessing\n"
        "from loopelastica.rod.kernels import jit\n"
        "jit._PATIENCE_S = 0.0\n"
        f"HINGE = {HINGE!r}\n"
        "def work(_):\n"
        "    barrier.wait()\n"
        "    exec(HINGE, {})\n"
        "context = multiprocessing.get_context('fork')\n"
        "barrier = context.Barrier(2)\n"
        "workers = [context.Process(target=work, args=(k,)) for k in range(2)]\n"
        "for worker in workers: worker.start()\n"
        "for worker in workers: worker.join()\n"
    )
    stdout, stderr = run(workers, tmp_path, package)
    assert len(stdout.splitlines()) == 2
    assert stderr.count("compiling the solver") == 1


@pytest.mark.slow
def test_an_unknown_numba_has_its_own_cache(package, tmp_path):
    unknown = "import numba\nnumba.__version__ = '99.0.0'\n" + HINGE
    stdout, _ = run(unknown, tmp_path, package)
    assert compiled_and_value(stdout)[1] == pytest.approx([1.2870022175865687, 0.0, 0.0])
    assert not (tmp_path / "cache").exists()


@pytest.mark.slow
def test_kernels_are_interpreted_where_compilation_is_switched_off(package, tmp_path):
    stdout, _ = run(HINGE, tmp_path, package, NUMBA_DISABLE_JIT="1")
    assert compiled_and_value(stdout) == (0, pytest.approx([1.2870022175865687, 0.0, 0.0]))


@pytest.mark.slow
def test_old_sets_of_compiled_code_are_removed(package, tmp_path):
    old = [tmp_path / "cache" / f"{k:020x}" for k in range(12)]
    others = [tmp_path / "cache" / name for name in ("mine", "0123", f"{1:021x}", f"{1:019x}g")]
    for k, folder in enumerate(others + old):
        folder.mkdir(parents=True)
        os.utime(folder, (k, k))
    run(HINGE, tmp_path, package)
    left = [folder for folder in old if folder.is_dir()]
    assert left == old[-8:]
    # what the program did not write stays
    assert all(folder.is_dir() for folder in others)


def test_the_numba_that_is_installed_is_one_the_package_knows():
    requirement = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    lower, upper = (".".join(map(str, version)) for version in jit.SUPPORTED)
    assert f"numba>={lower},<{upper}" in requirement
    version = tuple(int(part) for part in numba.__version__.split(".")[:2])
    assert jit.SUPPORTED[0] <= version < jit.SUPPORTED[1]
