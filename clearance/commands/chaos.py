"""`clearance run --error 5% --max-turns N` of chaotic motion: recognised, then statistics over
turns.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

LOOKED_AT = 64  # turns over which a motion is looked at


def add_turns(command: argparse.ArgumentParser) -> None:
    """--max-turns and --starts."""
    command.add_argument(
        "--max-turns",
        type=int,
        metavar="N",
        help="of chaotic motion, whose statistics --error asks for (default 5%%): turns of all "
        "starts together that "
        "they may take, at least 40 a start (default 20000)",
    )
    command.add_argument(
        "--starts",
        type=int,
        metavar="N",
        help="of chaotic motion: runs side by side, from different starts (default 4)",
    )


@dataclass(frozen=True)
class Chaotic:
    """A chaotic motion whose statistics are asked for: half width over mean by name, and its
    horizon in words.
    """

    asked: float | dict[str, float]
    horizon: str

    def statistics(self, options, scene, output: Path) -> tuple[dict, str | None]:
        """Statistics into the run's file, with a picture where one is wanted: part of the summary,
        and what failed.
        """
        from clearance.simulation import SimulationError

        try:
            result = self._run(options, scene)
        except SimulationError as error:
            return {"horizon": self.horizon}, f"statistics: {error}"
        result.append(output)
        summary = {
            "horizon": self.horizon,
            "turn_statistics": result.plain() | {"lines": result.lines()},
        }
        summary["errors"] = {"reason": "of one chaotic run; see the statistics"}
        if options.plot:
            from clearance.postprocess.turn_peaks import turn_peaks

            picture = output.with_name(f"{output.stem}_turns.png")
            summary["statistics_plot"] = str(turn_peaks(output, picture))
        return summary, None if result.reached else f"statistics: {result.verdict}"

    def _run(self, options, scene):
        from clearance.chaos import MOST_TURNS, STARTS, statistics
        from clearance.commands.run import ProgressBar

        bar = ProgressBar() if not options.json and sys.stderr.isatty() else None
        try:
            return statistics(
                scene,
                self.asked,
                rtol=options.rtol,
                method=options.method,
                progress=bar,
                max_turns=MOST_TURNS if options.max_turns is None else options.max_turns,
                starts=STARTS if options.starts is None else options.starts,
            )
        finally:
            if bar is not None:
                bar.close()


def recognised(options, scene) -> Chaotic | None:
    """The chaotic motion whose statistics are asked for; None for other motions and requests.

    Raises ValueError for --max-turns and --starts of a motion that is not chaotic.
    """
    counted = options.max_turns is not None or options.starts is not None
    if options.steady is not None or options.error in (None, "state") and not counted:
        return None
    limit = _horizon(options, scene)
    if limit is not None and limit.time is not None:
        return Chaotic(asked_of(options.error), limit.sentence(scene.turn))
    if counted:
        words = "it has no dry impacts over turns" if limit is None else limit.sentence(scene.turn)
        raise ValueError(f"--max-turns and --starts are for chaotic motion; of this one: {words}")
    return None


def _horizon(options, scene):
    """Of a scene that turns and has impacts without a film; else None."""
    from clearance.evidence.problem import NotSolved, horizon
    from clearance.sweeping.peaks import is_dry

    if scene.turn is None or not is_dry(scene.description()):
        return None
    try:
        return horizon(scene, LOOKED_AT * scene.turn, options.rtol, options.method, LOOKED_AT)
    except NotSolved:
        return None


def asked_of(text: str | None) -> float | dict[str, float]:
    """Half width over mean, by name: of all quantities, of peaks where a largest value is asked
    for.
    """
    from clearance.chaos import ERROR
    from clearance.request import ALL, INTEGRATION, Request

    def _named(name: str) -> str:
        if name in (ALL, INTEGRATION):
            return "*"
        return f"{name.removesuffix('_max')}_peak" if name.endswith("_max") else name

    if text in (None, "state"):
        return ERROR
    asked = sorted(
        Request.of(text).asked.items(), key=lambda pair: pair[0] not in (ALL, INTEGRATION)
    )
    return {_named(name): share for name, share in asked}


def lines(summary: dict) -> list[str]:
    """Lines of a run's summary."""
    if "turn_statistics" not in summary:
        return []
    first, *others = summary["turn_statistics"]["lines"]
    return [f"  statistics   {first}", *(f"  {line}" for line in others)]
