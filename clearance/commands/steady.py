"""`clearance run --steady`: the periodic motion of a case in place of a run from its start."""

import math
from collections.abc import Iterable
from pathlib import Path

from clearance.commands.accuracy import rounded_up
from clearance.commands.common import (
    channel_patterns,
    log_to_terminal,
    progress_of,
    share,
    taken,
)

#: options of a run from its start
OTHERS = "turns until max_step checkpoint settle pressure_fields"
DEFAULT_RTOL = 1e-6  # of `clearance run`; a periodic motion has a finer one
LISTED = 6  # multipliers in print, at most
LEAST = 1e-6  # error of a multiplier in print, at least


OPTIONS = {
    "--steady TOL": (
        share,
        None,
        "solve for the periodic motion, to this distance in natural sizes, such as 1e-6; the "
        "file holds one period",
    ),
    "--most-turns N": (
        400,
        "of --steady: turns after which no periodic motion is expected any more",
    ),
    "--period S": ("s", None, "of --steady: takes the place of the turn of the drive"),
}


def check(options) -> None:
    """Raises ValueError for options that belong to a run from its start. Numbers are then those
    of the period.
    """
    if options.steady is None:
        return
    for name, value in taken(options, OTHERS).items():
        if value is not None:
            raise ValueError(
                f"--{name.replace('_', '-')} has no meaning beside --steady: "
                "the file holds one period"
            )
    options.settle = 0.0


def solved(options, case, scene, output: Path):
    """The result with one period; nothing ends it early."""
    from clearance.motions.steady import steady

    log_to_terminal(options)
    with progress_of(options) as line:
        result = steady(
            scene,
            options.steady,
            rtol=None if options.rtol == DEFAULT_RTOL else options.rtol,
            path=output,
            progress=line,
            samples_per_turn=int(options.samples_per_turn),
            channels=channel_patterns(options.channels),
            **taken(options, "most_turns period start method compression error sensitivity"),
        )
    return result.orbit, None


def summary(result) -> dict:
    """Summary of a periodic motion from its file."""
    facts = {
        name: getattr(value, "item", lambda v=value: v)()
        for name, value in result.facts("steady").items()
        if not name.startswith("multipliers")
    }
    values = {
        "multipliers": [[m.real, m.imag] for m in multipliers(result)],
        "multiplier_errors": errors(result),
    }
    return {"steady": facts | values}


def multipliers(result) -> list[complex]:
    """Floquet multipliers of a periodic motion's file, the largest first."""
    facts = result.facts("steady")
    return [
        complex(*pair)
        for pair in zip(facts["multipliers_real"], facts["multipliers_imaginary"], strict=True)
    ]


def errors(result) -> list[float]:
    """Errors of the multipliers; nan in files that have none."""
    facts = result.facts("steady")
    missing = [math.nan] * len(facts["multipliers_real"])
    return [float(error) for error in facts.get("multipliers_error", missing)]


def lines(facts: dict | None) -> list[str]:
    """A periodic motion in print."""
    if facts is None:
        return []
    turns = f"{facts['period']} turns" if facts["period"] > 1 else "one turn"
    solved = f"{facts['turns_spent']:.0f} turns in all"
    text = [
        f"  steady       period {turns}, {facts['duration']:.9g} s; periodic to "
        f"{facts['change']:.1e} of the natural sizes, {facts['distance']:.1e} away",
        f"  turns        {facts['waited']} plain ones, {solved}",
    ]
    if facts["slow"]:
        waiting = f"; waiting: about {facts['plain_turns']:.0f}" if facts.get("plain_turns") else ""
        text.append(f"  solved for   {facts['slow']}{waiting}")
    values = [complex(*pair) for pair in facts["multipliers"]]
    spreads = facts["multiplier_errors"]
    text.append(f"  multipliers  {', '.join(shown(values, spreads))}")
    if any(abs(m) + error >= 1.0 for m, error in zip(values, spreads, strict=True)):
        text.append("  doubt        a multiplier has the size 1 within its error")
    return text


def shown(values: Iterable[complex], errors: Iterable[float]) -> list[str]:
    """Multipliers with their errors, conjugate pairs as one; the smallest of many are left out."""
    texts = [_stated(m, e) for m, e in zip(values, errors, strict=True) if m.imag >= 0.0]
    return texts if len(texts) <= LISTED else [*texts[:LISTED], "..."]


def _stated(value: complex, error: float) -> str:
    """A multiplier to the last digit that its error leaves."""
    if not math.isfinite(error):
        return f"{value.real:.4g}" + (f" +- {value.imag:.4g} i" if value.imag else "")
    error = rounded_up(max(error, LEAST))
    decimals = max(-math.floor(math.log10(error)), 0)
    text = f"{value.real:z.{decimals}f}"
    if value.imag:
        text = f"({text} +- {value.imag:.{decimals}f} i)"
    return f"{text} +- {error:.{decimals}f}"
