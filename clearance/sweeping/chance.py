"""The one scatter call: a case and distributions in, the spread of its metrics out."""

from collections.abc import Mapping
from pathlib import Path

from clearance import checks
from clearance.sweeping.driver import sweep
from clearance.sweeping.scatter import (
    DISTRIBUTIONS,
    Distribution,
    Scatter,
    design,
    from_words,
    write,
)


def scatter(
    case: str | Path,
    spread: Mapping[str, Distribution | str],
    folder: str | Path,
    *,
    points: int = 1024,
    seed: int = 0,
    limits: Mapping[str, float] | None = None,
    channels: list[str] | tuple[str, ...] = (),
    **options,
) -> Scatter:
    """Run a case with parameters that vary by chance, each by itself, and return the spread of its
    metrics.

    spread: distributions by parameter, SI units, also in words: {"clearance": "normal(1e-4,
        5e-6)"}; points: runs in all, at most; seed: the same seed, the same points; limits: of
        metrics, whose probability of going beyond is asked for. channels: kept in run files (none:
        no files); options: of `sweep`, among them fixed and turns. The same call again runs only
        what is missing. Raises ValueError for wrong input, and what `sweep` raises.
    """
    laws = {n: law if isinstance(law, Distribution) else _law(n, law) for n, law in spread.items()}
    chosen, n = design(laws, points, seed)
    swept = sweep(case, chosen, folder, channels=list(channels), **options)
    result = Scatter(
        swept, laws, n, {m: checks.finite(f"limit of {m}", v) for m, v in (limits or {}).items()}
    )
    write(result, Path(folder))
    return result


def _law(name: str, text: str) -> Distribution:
    law = from_words(text)
    if law is None:
        raise ValueError(
            f"{name}: {text!r} is no distribution; there are {', '.join(DISTRIBUTIONS)}"
        )
    return law
