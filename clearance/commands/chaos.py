"""`clearance run --error 5% --max-turns N` of chaotic motion: recognised, then statistics over
turns.
"""

from dataclasses import dataclass
from pathlib import Path

LOOKED_AT = 64  # turns over which a motion is looked at
MEANING = (
    "the motion is chaotic; the request is for half of the 95 % interval over the mean of a turn"
)


OPTIONS = {
    "--max-turns N": (
        int,
        None,
        "of chaotic motion, whose statistics --error requests (default 5%): turns of all "
        "starts together that they may take, at least 40 a start (default 20000)",
    ),
    "--starts N": (
        int,
        None,
        "of chaotic motion: runs side by side, from different starts (default 4)",
    ),
}


@dataclass(frozen=True)
class Chaotic:
    """A chaotic motion whose statistics are requested: half width over mean by quantity, turns of
    all starts, starts, and its horizon in words.
    """

    asked: dict[str, float]
    max_turns: int
    starts: int
    horizon: str

    def statistics(self, options, scene, output: Path) -> tuple[dict, str | None]:
        """Statistics into the run's file, with a picture where one is requested: part of the
        summary, and what failed.
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
        summary["errors"] = {"reason": MEANING}
        if options.plot:
            from clearance.postprocess.turn_peaks import turn_peaks

            picture = output.with_name(f"{output.stem}_turns.png")
            summary["statistics_plot"] = str(turn_peaks(output, picture))
        return summary, None if result.reached else f"statistics: {result.verdict}"

    def _run(self, options, scene):
        from clearance.motions.chaos import statistics

        return statistics(
            scene,
            self.asked,
            rtol=options.rtol,
            method=options.method,
            progress=not options.json,
            max_turns=self.max_turns,
            starts=self.starts,
        )


def recognised(options, scene) -> Chaotic | None:
    """The chaotic motion whose statistics are requested; None for other motions and requests.

    Raises ValueError for --max-turns and --starts of a motion that is not chaotic, and for numbers
    and names that its statistics cannot have.
    """
    from clearance.results.errors import asks

    counted, error = options.max_turns is not None or options.starts is not None, options.error
    if options.steady is not None or not asks(error) and not counted:
        return None
    from clearance.accuracy.request import Request
    from clearance.mechanism.build import build
    from clearance.motions.chaos import ERROR, MOST_TURNS, STARTS, asked_of, check_turns, quantities

    starts = STARTS if options.starts is None else options.starts
    max_turns = MOST_TURNS if options.max_turns is None else options.max_turns
    check_turns(max_turns, starts)
    error = Request.of(error).asked if asks(error) else ERROR
    limit = _horizon(options, scene)
    if limit is not None and limit.time is not None:
        asked = asked_of(error, quantities(build(scene)))
        return Chaotic(asked, max_turns, starts, limit.sentence(scene.turn))
    if counted:
        words = "it has no dry impacts over turns" if limit is None else limit.sentence(scene.turn)
        raise ValueError(f"--max-turns and --starts are for chaotic motion; of this one: {words}")
    return None


def _horizon(options, scene):
    """Of a scene that turns and has impacts without a film; else None."""
    from clearance.accuracy.horizon import NotSolved, horizon
    from clearance.metrics.of_points import is_dry

    if scene.turn is None or not is_dry(scene.description()):
        return None
    try:
        return horizon(scene, LOOKED_AT * scene.turn, options.rtol, options.method, LOOKED_AT)
    except NotSolved:
        return None


def lines(summary: dict) -> list[str]:
    """Lines of a run's summary."""
    if "turn_statistics" not in summary:
        return []
    first, *others = summary["turn_statistics"]["lines"]
    return [f"  statistics   {first}", *(f"  {line}" for line in others)]
