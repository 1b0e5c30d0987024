"""Random calls of the public API, valid, extreme and impossible, with documented outcomes only.

    python tests/fuzz/soak.py --minutes 60 --seed 1

A call ends in a result that is finite, read-only and agrees with itself, or in an exception that
its docstring names, whose message is one line and names the argument or the file. Whatever else
happens is printed with its number; ``--seed 1 --only 1234`` makes that call again and shows the
traceback.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import faulthandler
import signal
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import soak_calls as calls

import loopelastica as le

LONGEST_S = 120
"""No call takes longer; the longest ones are given a time limit of their own."""


@dataclass
class Tally:
    """What became of the calls."""

    outcomes: collections.Counter[tuple[str, str]] = field(default_factory=collections.Counter)
    undocumented: dict[tuple[str, str], list[str]] = field(default_factory=dict)

    def __str__(self) -> str:
        lines = [f"{n:7d}  {name}: {what}" for (name, what), n in sorted(self.outcomes.items())]
        kinds = [f"{len(found):7d}  {found[0]}" for found in self.undocumented.values()]
        n_faults = sum(len(found) for found in self.undocumented.values())
        return "\n".join([*lines, f"{n_faults} undocumented, of {len(kinds)} kinds", *kinds])


class TooLong(BaseException):
    """A call did not come back."""


@contextlib.contextmanager
def alarm(seconds: int) -> Iterator[None]:
    """Raise `TooLong` in a call that takes longer; kill the process if not even that ends it."""

    def ring(*_: object) -> None:
        raise TooLong(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    faulthandler.dump_traceback_later(4 * seconds, exit=True)
    try:
        yield
    finally:
        signal.alarm(0)
        faulthandler.cancel_dump_traceback_later()
        signal.signal(signal.SIGALRM, before)


def documented(error: BaseException) -> bool:
    """Whether an exception is one that users are prepared for, in one line that names its cause."""
    text = str(error)
    one_line = bool(text.strip()) and "\n" not in text and len(text) < 600 and text.isprintable()
    if isinstance(error, le.LoopelasticaError):
        return one_line
    return type(error) is ValueError and one_line and "`" in text


def one_call(seed: int, number: int, choose: Callable[[Any], Any] | None = None) -> tuple[str, str]:
    """Make call `number` of a seed: its name, and how it ended.

    Raises
    ------
    BaseException
        Whatever is not documented.
    """
    rng = np.random.default_rng([seed, number])
    name, call = calls.chosen(rng)
    with warnings.catch_warnings(), alarm(LONGEST_S):
        warnings.simplefilter("error")
        # of compiling, where no compiled code is at hand
        warnings.filterwarnings("ignore", category=UserWarning, module="loopelastica")
        warnings.filterwarnings("ignore", category=DeprecationWarning)
        warnings.filterwarnings("ignore", category=PendingDeprecationWarning)
        try:
            call(rng)
        except Exception as error:
            if not documented(error):
                raise
            return name, type(error).__name__
    return name, "a result"


def _place(error: BaseException) -> str:
    """The line of the package where it came from; where there is none, the last one."""
    lines = traceback.extract_tb(error.__traceback__)
    ours = [line for line in lines if "/loopelastica/" in line.filename] or lines
    return f"{Path(ours[-1].filename).name}:{ours[-1].lineno}"


def soak(seed: int, seconds: float, first: int = 0, report: Callable[[str], None] = print) -> Tally:
    """Make calls until the time is up; report each kind of undocumented outcome once.

    Parameters
    ----------
    seed : int
        Of all calls together.
    seconds : float
        How long.
    first : int
        Number of the first call.
    report : callable
        Takes each line.

    Returns
    -------
    Tally
    """
    tally, end, number = Tally(), time.monotonic() + seconds, first
    while time.monotonic() < end:
        try:
            tally.outcomes[one_call(seed, number)] += 1
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            name = calls.chosen(np.random.default_rng([seed, number]))[0]
            what = " ".join(f"{type(error).__name__}: {error}".split())[:300]
            place = _place(error)
            line = f"--seed {seed} --only {number}: {name}: {what} ({place})"
            kind = tally.undocumented.setdefault((type(error).__name__, place), [])
            if not kind:
                report(line)
            kind.append(line)
            tally.outcomes[name, "UNDOCUMENTED"] += 1
        number += 1
    return tally


def main() -> int:
    """Soak from the command line; exit status 1 if anything was undocumented."""
    parser = argparse.ArgumentParser(description="Random calls of the public API of loopelastica.")
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first call")
    parser.add_argument("--only", type=int, help="make this call only, with its traceback")
    given = parser.parse_args()
    if given.only is not None:
        print(one_call(given.seed, given.only))
        return 0
    tally = soak(
        given.seed, 60.0 * given.minutes, given.first, lambda line: print(line, flush=True)
    )
    print(tally)
    return int(bool(tally.undocumented))


if __name__ == "__main__":
    raise SystemExit(main())
