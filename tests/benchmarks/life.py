"""All turns of a life, run one after another, beside its jumps: `python tests/benchmarks/life.py`.

The outline changes after each turn by what the turn has worn off. A directory holds the direct run.
A killed one goes on from its last hundred turns. `--update` puts the table into the README beside.
"""

import json
import os
import shutil
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from publishing import publish

import clearance as cl
from clearance.laws.outline import NODES, Outline, worn
from clearance.motions.maps import Place
from clearance.run.wear_sum import Wearing
from clearance.simulation import prepare
from clearance.stepping import status
from clearance.stepping.state import IMPACT_SPEED, SINCE, TOUCHING

MARK = "<!-- direct life table -->"
PIECE = 100  # turns between two saved states
JOINT = "B"
PARTS = ("y", "carried", "touching", "speeds", "ages")


class Running(Wearing):
    """Wear that goes into the outline of the bearing at the end of each turn."""

    def reach(self, run):
        """Deepen the outline, where kernels and sums read it."""
        super().reach(run)
        depths = self.sums[JOINT].outline
        depths["bearing"] = depths["bearing"] + self.turns[JOINT][-1].depths["bearing"]
        par, places = run.mechanism.par, run.mechanism.layout.parameters
        key, numbers = self.sums[JOINT].joint.key, Outline(None, depths).numbers
        self.sums[JOINT].numbers = numbers
        first = int(par[places[f"{key}/outline/start"]])
        par[first : first + len(numbers)] = numbers
        par[places[f"{key}/worn"]] = 1.0


def piece(scene: cl.Scene, before: dict, turns: int, options: dict) -> dict:
    """So many turns on from a saved state: the state behind them."""

    def element(one):
        if one.name != JOINT:
            return one
        return replace(one, outline=worn(bearing=before["depth"]))

    run = prepare(scene.rebuilt(element=element), turns=turns, samples_per_turn=10, **options)
    if "y" in before:
        run.begin_at(Place(**{name: before[name] for name in PARTS}))
    wearing = Running(run, scene.turn)
    run.observers.append(wearing)
    if (code := run.go()) != status.DONE:
        raise SystemExit(f"a run ended with status {code} after {before['turns']} turns")
    state = run.state
    contacts = state.contacts.copy()
    return {
        "turns": before["turns"] + turns,
        "depth": wearing.sums[JOINT].outline["bearing"],
        "steps": before["steps"] + int(state.steps),
        "y": state.y[: run.mechanism.size].copy(),
        "carried": state.work[run.mechanism.layout.carried_places].copy(),
        "touching": contacts[:, TOUCHING] > 0.0,
        "speeds": contacts[:, IMPACT_SPEED],
        "ages": state.time - contacts[:, SINCE],
    }


def direct(case: dict, turns: int, folder: Path, options: dict) -> dict:
    """All turns of a life, from the last state that the directory has."""
    folder.mkdir(parents=True, exist_ok=True)
    path, scene = folder / "state.npz", cl.load_case("wear_a", **case)
    now = {"turns": 0, "depth": np.zeros(NODES), "steps": 0, "cpu": 0.0, "wall": 0.0}
    if path.exists():
        with np.load(path) as arrays:
            now = {name: arrays[name] for name in arrays.files}
    while now["turns"] < turns:
        cpu, wall = time.process_time(), time.perf_counter()
        new = piece(scene, now, min(PIECE, turns - int(now["turns"])), options)
        new["cpu"] = now["cpu"] + time.process_time() - cpu
        new["wall"] = now["wall"] + time.perf_counter() - wall
        now = new
        temporary = folder / "state.partial.npz"
        np.savez(temporary, **now)
        os.replace(temporary, path)
        history = {n: float(now[n]) for n in ("turns", "cpu", "wall")}
        history["depth"] = float(now["depth"].max())
        with open(folder / "history.jsonl", "a") as file:
            file.write(json.dumps(history) + "\n")
    return now


def jumps(case: dict, turns: int, options: dict) -> tuple[cl.Life, float, float]:
    """The same life by jumps: it, its CPU and wall time in a process that has compiled before."""
    with tempfile.TemporaryDirectory() as folder:
        cl.wear("wear_a", turns=2, directory=Path(folder) / "first", **case, **options)
        cpu, wall = time.process_time(), time.perf_counter()
        life = cl.wear("wear_a", turns=turns, directory=Path(folder) / "life", **case, **options)
        spent = time.process_time() - cpu, time.perf_counter() - wall
        life.depth(JOINT)  # its arrays stay when the directory goes
        return life, *spent


#: the jumps that are measured: with the stepper and tolerance of the direct run, and the default
KINDS = {
    "jumps, as the direct run": {"share": 0.5, "settle": 1, "average": 1},
    "jumps, defaults": {},
}


def rows(turns: int, folder: Path, parameters: dict) -> list[str]:
    """The table: a row for the direct run, one for each set of options of the jumps."""
    now = direct({}, turns, folder, parameters)
    deep, volume, cpu = (float(v) for v in (now["depth"].max(), now["depth"].sum(), now["cpu"]))
    lines = [
        "| life | turns run | depth | difference | stated | volume | CPU | turns or CPU saved |",
        "|---|---|---|---|---|---|---|---|",
        f"| each turn run | {turns} | {1e6 * deep:.3f} um | | | | {cpu:.0f} s | |",
    ]
    for name, options in KINDS.items():
        life, spent, _ = jumps({}, turns, options | (parameters if options else {}))
        depth, error = life.depth(JOINT)[-1], 1e6 * life.error[-1]
        run = sum(int(s["average"] + life.asked["settle"]) for s in life.stages)
        apart = 1e6 * (float(depth.max()) - deep)
        share = f"{float(depth.sum()) / volume - 1.0:+.1e}"
        cells = (
            name,
            f"{run}",
            f"{1e6 * float(depth.max()):.3f} um",
            f"{apart:+.3f} um",
            f"{error:.2g} um",
            share,
            f"{spent:.1f} s",
            f"{cpu / spent:.0f}x" if options else f"{turns / run:.0f}x by turns",
        )
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def table(chosen) -> list[str]:
    """Rows of the direct run, which goes on from its directory, and of the jumps."""
    folder = Path(chosen.directory)
    if chosen.fresh:
        shutil.rmtree(folder, ignore_errors=True)
    return rows(chosen.turns, folder, {"method": chosen.method, "rtol": chosen.rtol})


if __name__ == "__main__":
    publish(
        __doc__,
        table,
        MARK,
        turns=(21400, "of the life"),
        directory=("direct_life", "of the direct run"),
        method=("radau9", "of all runs"),
        rtol=(1e-3, "of all runs"),
        fresh=(False, "begin the direct run again"),
    )
