"""`clearance run --error 5% --max-turns N` of chaotic motion: recognised, then statistics over turns."""

import argparse
import sys
from pathlib import Path

LOOKED_AT = 64  # turns over which a motion is looked at


def add_turns(command: argparse.ArgumentParser) -> None:
    """--max-turns and --starts."""
    command.add_argument(
        "--max-turns", type=int, metavar="N",
        help="of chaotic motion: turns of all starts together that --error may take (default 20000)",
    )  # fmt: skip
    command.add_argument(
        "--starts", type=int, metavar="N",
        help="of chaotic motion: runs side by side, from different starts (default 4)",
    )  # fmt: skip


def recognised(options, scene) -> str | None:
    """The horizon of a chaotic motion whose statistics are asked for, in words; None for other motions and requests.

    Raises ValueError for --max-turns and --starts of a motion that is not chaotic.
    """
    counted = options.max_turns is not None or options.starts is not None
    if options.error in (None, "state") and not counted:
        return None
    found = _horizon(options, scene)
    if found is not None and found.time is not None:
        return found.sentence(scene.turn)
    if counted:
        said = "it has no impacts" if found is None else found.sentence(scene.turn)
        raise ValueError(f"--max-turns and --starts are for chaotic motion; of this one {said}")
    return None


def _horizon(options, scene):
    """Of a scene that turns and has impacts without a film; else None."""
    from clearance.evidence.problem import NotSolved, horizon
    from clearance.sweeping.peaks import is_dry

    if scene.turn is None or not is_dry(scene.description()):
        return None
    try:
        return horizon(scene, LOOKED_AT * scene.turn, options.rtol or 1e-6, options.method, LOOKED_AT)
    except NotSolved:
        return None


def asked_of(text: str | None) -> float | dict[str, float]:
    """Half width over mean: of all quantities, or of some by name."""
    from clearance.chaos import ERROR
    from clearance.request import ALL, Request

    if text in (None, "state"):
        return ERROR
    asked = dict(Request.of(text).asked)
    return asked[ALL] if set(asked) == {ALL} else {n: e for n, e in asked.items() if n != ALL}


def statistics_of(options, scene):
    """Statistics until they are as narrow as asked for; a bar on a terminal."""
    from clearance.chaos import MOST_TURNS, STARTS, statistics
    from clearance.commands.run import ProgressBar

    bar = ProgressBar() if not options.json and sys.stderr.isatty() else None
    try:
        return statistics(
            scene, asked_of(options.error), max_turns=options.max_turns or MOST_TURNS, rtol=options.rtol or 1e-6,
            starts=options.starts or STARTS, method=options.method, progress=bar,
        )  # fmt: skip
    finally:
        if bar is not None:
            bar.close()


def lines_of(summary: dict) -> list[str]:
    """Lines of a run's summary."""
    first, *others = summary["turn_statistics"]["lines"]
    return [f"  statistics   {first}", *(f"  {line}" for line in others)]


def keep(found, horizon: str, output: Path, plot: bool) -> dict:
    """Statistics into the run's file, and a picture beside it where one is wanted; as plain data of the summary."""
    found.append(output)
    summary = {"horizon": horizon, "turn_statistics": found.plain() | {"lines": found.lines()}}
    if plot:
        from clearance.postprocess.turn_peaks import turn_peaks

        summary["statistics_plot"] = str(turn_peaks(output, output.with_name(f"{output.stem}_turns.png")))
    return summary
