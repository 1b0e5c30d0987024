"""Errors, interrupts and odd terminals: a sentence and an exit status, never a traceback."""

import contextlib
import csv
import errno
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from loopelastica._files import data_path
from loopelastica.cli.app import app
from loopelastica.cli.program import in_options

ROOT = Path(__file__).resolve().parents[2]
HAIRPIN = data_path("hairpins/2koc.pdb")
BUILD = ("build", "GGC(UUU)GCC", "--rna", "--candidates", "1", "--no-plot")
FAST = ("--no-plot", "--first-model")
CLAMPING = ("solve", "--clamping", "-0.4 -0.1 0.5 4.8 1.4 2.2")


def run(*arguments):
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def program(*arguments, env=None, **options):
    """The program in a process of its own."""
    words = [a if isinstance(a, bytes) else str(a) for a in arguments]
    return subprocess.run(
        [sys.executable, "-m", "loopelastica", *words],
        cwd=options.pop("cwd", ROOT), env={**os.environ, "PYTHONPATH": str(ROOT), **(env or {})},
        stdout=options.pop("stdout", subprocess.PIPE),
        stderr=options.pop("stderr", subprocess.PIPE), timeout=300,
        **options,
    )  # fmt: skip


@contextlib.contextmanager
def files_of_at_most(size):
    """A disk that has room for so many bytes of each file."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def said(result, *, fragments):
    """The one sentence on the standard error, in which the fragments are."""
    lines = [line for line in result.stderr.splitlines() if line.strip() and "%|" not in line]
    assert len(lines) == 1, lines
    for fragment in fragments:
        assert str(fragment) in lines[0]
    return lines[0]


def table(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """The first model of 2KOC."""
    path = tmp_path_factory.mktemp("small") / "ok.pdb"
    path.write_text(HAIRPIN.read_text().split("ENDMDL")[0] + "ENDMDL\nEND\n")
    return path


# --- output that fails ----------------------------------------------------------------------------


def outputs(small, out):
    folder = small.parent
    return {
        "fold": ("fold", small, *FAST, "-o", out),
        "fold --jobs": ("fold", small, *FAST, "--jobs", 1, "-o", out),
        "build": (*BUILD, "-o", out),
        "evaluate": ("evaluate", folder, "-o", out),
        "hairpins": ("hairpins", small, "--json", out / "a.json"),
        "bench atoms": ("bench", "atoms", folder, "-o", out),
        "bench simulation": ("bench", "simulation", folder, "-o", out),
        "studies motifs": ("studies", "motifs", folder, "-o", out),
        "bench paper": ("bench", "paper", "-o", out),
        "bench stability": ("bench", "stability", "-o", out),
        "bench accuracy": ("bench", "accuracy", "-o", out),
        "bench scaling": ("bench", "scaling", "-o", out),
        "bench nanostructures": ("bench", "nanostructures", "-o", out),
    }


COMMANDS = list(outputs(Path("x/y"), Path("z")))


@pytest.mark.parametrize("command", COMMANDS)
def test_a_file_where_the_folder_should_be_is_one_sentence(small, tmp_path, command):
    out = tmp_path / "out"
    out.write_text("")
    result = run(*outputs(small, out)[command])
    assert result.exit_code == 1
    said(result, fragments=[out, "cannot be written"])
    assert out.read_text() == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_a_folder_that_takes_nothing_is_one_sentence(small, command):
    # /proc takes nothing from root either
    result = run(*outputs(small, Path("/proc/loopelastica"))[command])
    assert result.exit_code == 1
    assert str(small) not in said(result, fragments=["/proc/loopelastica", "cannot be written"])


@pytest.mark.parametrize("command", ["fold", "fold --jobs", "build", "evaluate", "hairpins"])
@pytest.mark.parametrize("size", [0, 300])
def test_a_full_disk_is_told_of_the_output(small, tmp_path, command, size):
    out = tmp_path / "out"
    with files_of_at_most(size):
        result = run(*outputs(small, out)[command])
    assert result.exit_code == 1, result.stderr
    assert f"{out}" in result.stderr
    assert "cannot be written" in result.stderr
    left = [] if not out.exists() else [p.name for p in out.iterdir() if p.is_dir()]
    assert left == []


def test_a_disk_that_is_full_stops_the_run_and_the_next_one_goes_on(small, tmp_path, monkeypatch):
    files = [tmp_path / f"copy{k}.pdb" for k in range(4)]
    for file in files:
        shutil.copy(small, file)
    out, calls = tmp_path / "out", []
    import loopelastica.batch.folds as folds

    write = folds.write_fold

    def full_at_third(path, *arguments, **options):
        calls.append(path)
        if len(calls) == 3:
            from loopelastica._files import writing

            with writing(path):
                raise OSError(28, "No space left on device")
        return write(path, *arguments, **options)

    monkeypatch.setattr(folds, "write_fold", full_at_third)
    command = ("fold", *files, *FAST, "--jobs", 1, "-o", out)
    result = run(*command)
    assert result.exit_code == 1
    said(result, fragments=["copy2_A6-9: cannot be written (No space", "2 of 4 files", "goes on"])
    assert [row["file"] for row in table(out / "summary.csv") if row["rank"] == "1"] == [
        str(f) for f in files[:2]
    ]
    result = run(*command)
    assert result.exit_code == 0
    assert "4 files (2 were done before)" in result.output
    assert len({row["file"] for row in table(out / "summary.csv")}) == 4


@pytest.mark.parametrize("arguments", [("--help",), CLAMPING, ("hairpins", HAIRPIN)])
def test_a_full_disk_behind_the_standard_output_is_one_sentence(arguments):
    with open("/dev/full", "w") as full:
        done = program(*arguments, stdout=full)
    assert done.returncode == 1
    assert done.stderr.decode() == "standard output: No space left on device\n"


@pytest.mark.parametrize("arguments", [("--help",), CLAMPING, ("hairpins", HAIRPIN)])
def test_a_reader_that_has_seen_enough_hears_no_more(arguments):
    read, write = os.pipe()
    os.close(read)
    done = program(*arguments, stdout=write)
    os.close(write)
    assert done.stderr.decode() == ""


# --- odd terminals and names ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("env", "jobs"),
    [
        ({"PYTHONIOENCODING": "ascii"}, ()),
        ({"PYTHONIOENCODING": "ascii"}, ("--jobs", "1")),
        ({"LC_ALL": "C"}, ("--jobs", "1")),
    ],
)
def test_a_terminal_of_ascii_is_enough(small, tmp_path, env, jobs):
    odd = tmp_path / "hä′ü.pdb"
    shutil.copy(small, odd)
    done = program("fold", odd, tmp_path / "ä.pdb", *FAST, "-o", tmp_path / "o", *jobs, env=env)
    text = done.stderr.decode("utf-8") + done.stdout.decode("utf-8")
    assert done.returncode == 1, text
    assert "Traceback" not in text
    assert "there is no such file" in text
    if env == {"PYTHONIOENCODING": "ascii"}:
        assert (done.stderr + done.stdout).isascii()
        assert "(1/A)" in text
    rows = table(tmp_path / "o" / "summary.csv")
    assert {row["file"] for row in rows} == {str(odd)}


@pytest.mark.parametrize("arguments", [("solve", "--help"), CLAMPING, ("hairpins", HAIRPIN)])
def test_help_and_tables_come_on_a_terminal_of_ascii(arguments):
    done = program(*arguments, env={"PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
def test_a_name_that_is_no_utf8_is_folded_like_others(small, tmp_path, jobs):
    odd = os.fsencode(tmp_path) + b"/odd\xff\xfe.pdb"
    shutil.copy(small, odd)
    gone = os.fsencode(tmp_path) + b"/gone\xff.pdb"
    out = tmp_path / "out"
    done = program("fold", odd, gone, small, *FAST, "-o", out, *jobs)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr.decode()
    names = {Path(row["file"]).name for row in table(out / "summary.csv")}
    assert names == {"odd\\udcff\\udcfe.pdb", "ok.pdb"}
    (failure,) = table(out / "failures.csv")
    assert failure["file"].endswith("gone\\udcff.pdb")
    assert done.stdout.count(b"candidates in") == len(jobs) / 2


# --- options --------------------------------------------------------------------------------------

ALONE = ("hairpins", "absent.pdb")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("fold", "absent.pdb", "--contact", "sheared"), "--contact needs --atoms"),
        (("fold", "absent.pdb", "--atoms", "--contact", "x"), "--contact is 'x'; it must be one"),
        (("fold", "absent.pdb", "--torsion-ratio", "2"), "--torsion-ratio needs --darboux"),
        (("fold", "absent.pdb", "--jobs", "2", "--scheduler", "tcp://a:1"), "goes without"),
        (("fold", "absent.pdb", "--scheduler", "nonsense"), "--scheduler is 'nonsense'"),
        (("fold", "absent.pdb", "--scheduler", "foo://a:1"), "--scheduler is 'foo://a:1'"),
        (("fold", "absent.pdb", "--jobs", "0"), "--jobs"),
        (("fold", "absent.pdb", "--taper", "nan"), "--taper is nan"),
        (("fold", "absent.pdb", "--persistence-length", "nan"), "--persistence-length is nan"),
        (("fold", "absent.pdb", "--length-per-nucleotide", "0"), "--length-per-nucleotide is 0.0"),
        (("fold", "absent.pdb", "--energy-max", "-1"), "--energy-max is -1.0"),
        (("fold", "absent.pdb", "--darboux", "--torsion-ratio", "inf"), "--torsion-ratio is inf"),
        (
            ("fold", "absent.pdb", "--pair", "nonsense"),
            "--pair is 'nonsense'; it must be like A.12",
        ),
        (("fold", "absent.pdb", "--loop", "A.6"), "--loop is 'A.6'; it must be like A.12"),
        (("fold", "absent.pdb", "--dot-bracket", "(("), "it must be like ((((....))))"),
        ((*ALONE, "--pair", "A.5"), "--pair is 'A.5'"),
        ((*ALONE, "--loop", "x"), "--loop is 'x'"),
        ((*ALONE, "--dot-bracket", "..)"), "--dot-bracket: ')' at place 3"),
        (("hairpins", HAIRPIN, "--pair", "A5-A10"), "with chains it is written A.5-A.10"),
        (("scan", "absent.pdb", "--taper", "nan"), "--taper is nan"),
        (("scan", "absent.pdb", "--taper", "0.4"), "--taper is 0.4"),
        (("scan", "absent.pdb", "--pair", "A.5"), "--pair is 'A.5'"),
        ((*BUILD, "--contact", "nonsense"), "--contact is 'nonsense'; it must be one of sheared"),
        (("build", "GGC", "--rna"), "SEQUENCE is 'GGC'"),
        ((*CLAMPING, "--free-spin", "--torsion-ratio", "2"), "--torsion-ratio goes without --free"),
        ((*CLAMPING, "--torsion-ratio", "-1"), "--torsion-ratio is -1.0"),
        ((*CLAMPING, "--energy-max", "nan"), "--energy-max is nan"),
        (("evaluate", ".", "--jobs", "2", "--scheduler", "tcp://a:1"), "--jobs goes without"),
        (("evaluate", "absent"), "FOLDER absent holds no PDB or mmCIF file: it is not there"),
        (("evaluate", HAIRPIN), "holds no PDB or mmCIF file: it is a file"),
        (("solve", "--clamping", "1 2 3"), "--clamping '1 2 3': it must be six finite numbers"),
        (("solve", "--clamping", "0 0 nan 0 0 0"), "it must be six finite numbers"),
        (("solve", "--clamping", "0 0 5 0 0 0"), "0 0 0': has its ends 5 rod lengths apart"),
        (("bench", "atoms", "absent"), "FOLDER absent holds no PDB or mmCIF file"),
        (("bench", "simulation", "absent"), "FOLDER absent holds no PDB or mmCIF file"),
        (("studies", "motifs", "absent"), "FOLDER absent holds no PDB or mmCIF file"),
        (("bench", "paper", "--full", "--sample", "3"), "--sample goes without --full"),
        (("bench", "paper", "--full", "--own-full"), "--own-full goes without --full"),
        (("bench", "stability", "--seed", "-1"), "--seed"),
        (("bench", "nanostructures", "--steps", "-1"), "--steps"),
    ],
)
def test_options_are_refused_by_their_names_before_anything_is_done(
    tmp_path, monkeypatch, arguments, sentence
):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert sentence in " ".join(result.stderr.split()).replace("'--", "--")
    assert "`" not in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_chain_that_is_not_there_is_answered_with_those_that_are():
    for option, text in (("--pair", "X.5-X.10"), ("--loop", "X.6-9")):
        result = run("hairpins", HAIRPIN, option, text)
        assert result.exit_code == 1
        said(result, fragments=["there is no nucleotide X.5, the chains are A", option])


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
def test_a_pair_that_the_file_shows_to_be_wrong_is_told_the_form(small, tmp_path, jobs):
    result = run("fold", small, "-o", tmp_path / "out", "--pair", "A5-A10", *FAST, *jobs)
    assert result.exit_code == 1
    (row,) = table(tmp_path / "out" / "failures.csv")
    assert row["failure"] == (f"{small}: --pair is 'A5-A10'; with chains it is written A.5-A.10")


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")])
@pytest.mark.parametrize("name", ["summary.csv", "failures.csv", "summary.parquet"])
def test_a_table_of_somebody_else_is_left_alone(small, tmp_path, name, jobs):
    theirs = tmp_path / name
    theirs.write_text("name,dose\nx,1\n")
    result = run("fold", small, "-o", tmp_path, *FAST, *jobs)
    assert result.exit_code == 1
    said(result, fragments=[theirs, "not written by this program"])
    assert os.listdir(tmp_path) == [name]
    assert theirs.read_text() == "name,dose\nx,1\n"
    theirs.write_bytes(b"")
    assert run("fold", small, "-o", tmp_path, *FAST, *jobs).exit_code == 0


def test_evaluate_leaves_a_table_of_somebody_else_alone(small, tmp_path):
    (tmp_path / "loops.csv").write_text("name,dose\n")
    result = run("evaluate", small.parent, "-o", tmp_path)
    assert result.exit_code == 1
    said(result, fragments=[tmp_path / "loops.csv", "not written by this program"])
    assert os.listdir(tmp_path) == ["loops.csv"]


def test_a_full_disk_leaves_the_rows_of_what_is_done(small, tmp_path, monkeypatch):
    import loopelastica.batch.folds as folder
    from loopelastica._files import OutputError

    write = folder.write_fold

    def full_for_b(path, *arguments):
        if path.name.startswith("b_"):
            raise OutputError(errno.ENOSPC, "No space left on device", str(path))
        return write(path, *arguments)

    for name in ("a.pdb", "b.pdb"):
        shutil.copy(small, tmp_path / name)
    monkeypatch.setattr(folder, "write_fold", full_for_b)
    out = tmp_path / "out"
    result = run("fold", tmp_path / "a.pdb", tmp_path / "b.pdb", "-o", out, *FAST)
    assert result.exit_code == 1
    said(result, fragments=[out / "b_A6-9", "No space left on device"])
    rows = table(out / "summary.csv")
    assert {row["file"] for row in rows} == {str(tmp_path / "a.pdb")}
    assert table(out / "failures.csv") == []


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_the_work_is_done_where_the_standard_error_takes_nothing(small, tmp_path):
    shutil.copy(small, tmp_path / "a.pdb")
    files = (tmp_path / "a.pdb", tmp_path / "absent.pdb")
    with Path("/dev/full").open("w") as full:
        result = program("fold", *files, "-o", tmp_path / "out", *FAST, stderr=full)
    assert result.returncode == 1
    assert {row["file"] for row in table(tmp_path / "out" / "summary.csv")} == {str(files[0])}
    (row,) = table(tmp_path / "out" / "failures.csv")
    assert row["file"] == str(files[1])


def test_arguments_become_options_where_the_command_has_them():
    assert in_options("`persistence_length_A` is -3") == "--persistence-length is -3"
    assert in_options("`equilibria` is no option") == "`equilibria` is no option"


def test_the_exit_statuses_stand_in_the_help_and_the_documentation():
    text = " ".join(run("--help").output.split())
    page = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    for status, meaning in (
        ("0", "done"),
        ("1", "some input"),
        ("2", "an argument"),
        ("130", "int"),
    ):
        assert f"{status} {meaning}" in text
        assert f"| {status} | {meaning}" in page


def test_a_mistake_in_solve_is_one_of_usage_and_no_solution_a_failure(monkeypatch):
    assert run("solve", "--clamping", "0 0 2 0 0 0").exit_code == 2
    import loopelastica.rod.equilibria as module

    class Nothing(list):
        starts, unseen, energy_max = 7, 1.0, 20.0

    monkeypatch.setattr(module, "equilibria", lambda *_: Nothing())
    result = run(*CLAMPING)
    assert result.exit_code == 1
    said(result, fragments=["no equilibrium found in 7 starts"])


# --- interrupts -----------------------------------------------------------------------------------


def interrupted(arguments, ready):
    """Send Ctrl-C as a terminal does, to all processes of the group, when it is time."""
    process = subprocess.Popen(
        [sys.executable, "-m", "loopelastica", *map(str, arguments), "--no-report"],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    deadline = time.monotonic() + 240
    while not ready(process.pid) and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    text = errors.decode().rsplit("\r", 1)[-1]
    assert process.returncode == 130, text
    assert "Traceback" not in errors.decode()
    for _ in range(100):
        left = subprocess.run(["pgrep", "-g", str(process.pid)], capture_output=True).stdout
        if not left:
            break
        time.sleep(0.1)
    assert left == b""
    lines = [line for line in text.splitlines() if line.strip() and "%|" not in line]
    assert len(lines) == 1, lines
    return lines[0]


def children(pid):
    found = subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True)
    return found.stdout.split()


def copies(small, folder, n):
    files = [folder / f"copy{k}.pdb" for k in range(n)]
    for file in files:
        shutil.copy(small, file)
    return files


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_an_interrupted_run_says_what_is_done_and_goes_on(small, tmp_path, jobs):
    if jobs > 1:
        pytest.importorskip("distributed")
    files, out = copies(small, tmp_path, 40), tmp_path / "out"
    command = ("fold", *files, *FAST, "--jobs", jobs, "-o", out)
    journal = out / ".summary.journal"
    sentence = interrupted(
        command, lambda _: journal.exists() and journal.read_bytes().count(b"\n") > 2
    )
    done = int(sentence.split(": ")[1].split(" of 40 files are done")[0])
    # the last one may be in the journal without being counted yet
    assert 2 <= done < 40
    assert "the same command goes on" in sentence
    assert len({row["file"] for row in table(out / "summary.csv")}) == done
    assert table(out / "failures.csv") == []
    result = run("fold", *files, *FAST, "--jobs", 1, "-o", out)
    assert result.exit_code == 0
    assert any(f"({n} were done before)" in result.output for n in (done, done + 1))


@pytest.mark.slow
def test_an_interrupted_fold_leaves_valid_tables(small, tmp_path):
    files, out = copies(small, tmp_path, 60), tmp_path / "out"
    sentence = interrupted(
        ("fold", *files, *FAST, "-o", out),
        lambda _: out.exists() and sum(p.is_dir() for p in out.iterdir()) > 3,
    )
    done = len({row["file"] for row in table(out / "summary.csv")})
    assert f"interrupted: {done} of 60 files are done; the same command" in sentence
    assert {p.name for p in out.iterdir() if p.name.startswith(".")} == set()


@pytest.mark.slow
def test_an_interrupt_while_workers_start_is_one_sentence(small, tmp_path):
    pytest.importorskip("distributed")
    out = tmp_path / "out"
    sentence = interrupted(
        ("fold", *copies(small, tmp_path, 3), *FAST, "--jobs", 2, "-o", out),
        # one that multiprocessing starts to look after the others, and both workers
        lambda pid: len(children(pid)) > 2,
    )
    assert "0 of 3 files are done" in sentence


# --- one run at a time ----------------------------------------------------------------------------


@pytest.mark.parametrize("jobs", [(), ("--jobs", 1)])
def test_a_second_run_in_a_folder_is_refused(small, tmp_path, jobs):
    from loopelastica.batch.lock import alone_in

    with alone_in(tmp_path / "out"):
        result = run("fold", small, *FAST, "-o", tmp_path / "out", *jobs)
    assert result.exit_code == 1
    said(result, fragments=[tmp_path / "out", "another run is at work in this folder"])
