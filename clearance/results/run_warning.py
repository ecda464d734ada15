"""Warnings of runs in Python: one for each run that has some."""

import warnings
from collections.abc import Sequence


class RunWarning(UserWarning):
    """The warnings of a run. Its result has them too, as `warnings`."""


def warn(texts: Sequence[str]) -> None:
    """Issue the warnings of a run as one, at the line that called a `watched` study; nothing for
    none.
    """
    if texts:
        heading = f"{counted(texts)} of this run, also in `result.warnings`:"
        warnings.warn("\n".join([heading, *texts]), RunWarning, stacklevel=4)


def counted(texts: Sequence[str]) -> str:
    """Number of warnings, in words."""
    return f"{len(texts) or 'no'} warning{'' if len(texts) == 1 else 's'}"
