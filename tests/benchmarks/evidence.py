"""Error against run time, extremes, the price of physics: `python tests/benchmarks/evidence.py
[NAME ...] [--update]`.

Runs the commands of the page beside this file with all peers (install the extras `peers` and
`oracles`). Their
folders stay in `--folder`; a study with a folder is not run again. The tables go into that page at
their marks, and the pictures into paper_figures. The name of a study makes its rows of the summary
again; the others stay.
"""

import math
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
from publishing import END, RESULTS, options, put

ROOT = Path(__file__).resolve().parent.parent.parent
PICTURES = ROOT / "paper_figures"
CLEARANCE = ("-m", "clearance.cli")

#: name: arguments of `clearance work-precision ... --peers`, which multibody.py runs with Exudyn
STUDIES = {
    "slider_crank": "slider_crank -p model=lubricated -p film=pinkus_sternlicht",
    "six_bar_feeder": "six_bar_feeder -p film=pinkus_sternlicht",
    "feeder_table": "six_bar_feeder",
    "slider_crank_thin": "slider_crank -p model=lubricated -p viscosity=0.04 -p "
    "film=pinkus_sternlicht",
    "feeder_600": "six_bar_feeder -p speed=600rpm",
    "feeder_300_BCE": "six_bar_feeder -p joints=B,C,E",
    "feeder_600_BCE": "six_bar_feeder -p joints=B,C,E -p speed=600rpm -p film=pinkus_sternlicht",
    "dry": "slider_crank -p model=dry --turns 0.5",
    "dry_memoryless": "slider_crank -p model=dry -p contact=hunt_crossley_memoryless",
}
SUMMARY = "<!-- evidence: summary -->"
SHOWN = ("slider_crank", "six_bar_feeder")
PEERS = (
    "scipy Radau",
    "scipy LSODA",
    "scipy DOP853",
    "numbalsoda LSODA",
    "numbalsoda DOP853",
    "CVODE BDF",
    "IDA",
    "Exudyn generalized-alpha",
)
LEVELS = (1e-3, 1e-4, 1e-6, 1e-8)


def command(folder: Path, *arguments: str, program: tuple[str, ...] = CLEARANCE) -> Path:
    """Run one command into its folder, unless it is there; the folder."""
    if not (folder.is_dir() and any(folder.glob("*.md"))):
        subprocess.run([sys.executable, *program, *arguments, "-o", str(folder)], check=True)
    return folder


def compared(folder: Path, name: str) -> Path:
    """The folder of a study of the error against run time, with all peers and Exudyn."""
    script = str(Path(__file__).with_name("multibody.py"))
    return command(folder / name, *STUDIES[name].split(), program=(script,))


def cheapest(file: h5py.File, curve: str, level: float) -> float:
    if curve not in file:
        return math.nan
    pairs = zip(file[curve]["seconds"][:], file[curve]["error"][:], strict=True)
    return min((s for s, e in pairs if e <= level), default=math.nan)


def summary(folders: dict[str, Path], levels=LEVELS) -> list[str]:
    """A row for each scene and error level: the fastest own method, and how many times longer
    others need.
    """
    short = [p.replace(" generalized-alpha", "") for p in PEERS]
    lines = [
        "| `work-precision` of | error | own | " + " | ".join(short) + " |",
        "|---" * (len(PEERS) + 3) + "|",
    ]
    for name, folder in folders.items():
        with h5py.File(folder / "work_precision.h5") as file:
            ours = [c for c in file if file[c].attrs["own"]]
            for level in levels:
                result = {c: cheapest(file, c, level) for c in ours}
                best = min((c for c in ours if result[c] > 0.0), key=result.get)
                ratios = [cheapest(file, p, level) / result[best] for p in PEERS]
                cells = ["-" if math.isnan(r) else f"{float(f'{r:.2g}'):g}x" for r in ratios]
                row = f"| `{STUDIES[name]}` | {level:.0e} | {best} {result[best] * 1e3:.2f} ms | "
                lines.append(row + " | ".join(cells) + " |")
    return lines


def solvers(folder: Path) -> dict[str, list[str]]:
    """Text for each mark of the error against run time, with all peers."""
    folders = {name: compared(folder, name) for name in STUDIES}
    texts = {name: published(folders[name], "work_precision", f"_{name}") for name in SHOWN}
    return {"summary": summary(folders)} | texts


def again(name: str) -> Callable[[Path], dict[str, list[str]]]:
    """The summary of the page, with the rows of one study made again."""

    def rows(folder: Path) -> dict[str, list[str]]:
        comparison = compared(folder, name)
        mine, page = f"| `{STUDIES[name]}` |", RESULTS.read_text()
        lines = page.partition(SUMMARY)[2].partition(END)[0].strip().splitlines()
        first = next(i for i, line in enumerate(lines) if line.startswith(mine))
        others = [line for line in lines if not line.startswith(mine)]
        return {"summary": others[:first] + summary({name: comparison})[2:] + others[first:]}

    return rows


def published(folder: Path, name: str, suffix: str = "") -> list[str]:
    """The table of a study; its picture goes into paper_figures."""
    shutil.copy(folder / f"{name}.png", PICTURES / f"{name}{suffix}.png")
    return (folder / f"{name}.md").read_text().splitlines()


def snapshots(folder: Path) -> dict[str, list[str]]:
    """No text: pressure in joint B along a turn is a picture alone."""
    run = folder / "run.h5"
    if not run.exists():
        scene = "six_bar_feeder -p model=lubricated -p joints=B --turns 6 -o"
        words = [sys.executable, *CLEARANCE, "run", *scene.split(), str(run)]
        subprocess.run(words, check=True)
    shots = command(folder / "film_snapshots", "film", "snapshots", str(run), "--joint", "B")
    shutil.copy(shots / "film_snapshots.png", PICTURES / "film_snapshots.png")
    return {}


def single(name: str, *arguments: str) -> Callable[[Path], dict[str, list[str]]]:
    """A study with one table and one picture of its name."""
    return lambda folder: {name: published(command(folder / name, *arguments), name)}


PHYSICS = "work-precision six_bar_feeder -p viscosity=5cP --physics"
SECTIONS = {
    "solvers": solvers,
    "film_ladder": single("film_ladder", "film", "ladder"),
    "film_convergence": single("film_convergence", "film", "convergence"),
    "film_snapshots": snapshots,
    "stress": single("stress", "stress"),
    "physics": single("physics", *PHYSICS.split()),
    **{name: again(name) for name in STUDIES},
}


def main():
    chosen = options(
        __doc__,
        names=([], f"parts of the page: {', '.join(SECTIONS)} (default all)"),
        folder=("evidence", "of the results (default evidence)"),
    )
    if unknown := [name for name in chosen.names if name not in SECTIONS]:
        raise SystemExit(f"no part {unknown[0]!r}; there are {', '.join(SECTIONS)}")
    for section in chosen.names or [s for s in SECTIONS if s not in STUDIES]:
        for name, lines in SECTIONS[section](Path(chosen.folder)).items():
            print(f"## {name}", *lines, "", sep="\n")
            if chosen.update:
                put(RESULTS, lines, f"<!-- evidence: {name} -->")


if __name__ == "__main__":
    main()
