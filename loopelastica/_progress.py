"""Progress bars: on a terminal only, so that logs and pipes stay clean."""

from typing import Any


def progress_bar(*arguments: Any, shown: bool = True, **options: Any) -> Any:
    """A progress bar of tqdm on the standard error.

    Parameters
    ----------
    *arguments, **options
        As for ``tqdm.tqdm``.
    shown : bool
        Whether there is to be one. There is none where the standard error is no terminal.

    Returns
    -------
    tqdm.tqdm
    """
    from tqdm import tqdm

    # None: tqdm asks the standard error whether it is a terminal
    return tqdm(*arguments, disable=None if shown else True, **options)
