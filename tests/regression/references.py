"""Reference results of the regression tests: which runs there are, how they are made, how they are
stored.

    python -m tests.regression.references [NAME ...] [--overwrite]

makes the files references/<name>.h5 of these runs (default: all), about two minutes with kernels
compiled. References are better than what they are compared with, and come another way where there
is one: integrated motions with a tolerance of 1e-10 by another stepper than the tests' default,
prescribed motions by the multiplier formulation, statistics from 24 runs, estimations from several
starts in place of one. For each it states how far a run with default settings is off, over what is
allowed; a third stepper (explicit for implicit, and the other way round) agreed with the integrated
motions within a hundredth of that. A result that has moved for a known reason is made anew with
--overwrite.
"""

import argparse
import json
import sys
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from clearance.paper_figures.ball_joint_bench import bench

import clearance as cl
from clearance.identify.fit import fit
from clearance.identify.models import model
from clearance.metrics.metrics import metrics
from clearance.results.reading import open_checked
from clearance.results.tables import save_tables
from clearance.scene.catalogue import find_case
from tests.oracles import pinocchio
from tests.oracles.multipliers import inverse

FOLDER = Path(__file__).parent / "references"
FORMAT, FORMAT_VERSION = "clearance-reference", 1
TIGHT = 1e-10  # rtol of references
SAMPLES = 101
DRAWS = 24  # runs of the statistics, of tolerances a little apart
KNOTS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # of the characteristic curve [rad/s]
# standard deviations that one draw may be off: by chance once in 15,000 times (24 draws, normal)
SIGMAS = 5.0
COLUMNS = ("time", "impact_speed", "peak_force", "peak_penetration", "duration")
CRANK = ("drives/crank/torque",)
ENERGY = ("energy/kinetic", "energy/potential", "energy/input", "energy/dissipated")
PINS = tuple(f"joints/*/{n}" for n in ("force_x", "force_y", "friction", "friction_load"))
JOURNAL = tuple(
    f"joints/*/{n}"
    for n in ("eccentricity_x", "eccentricity_y", "gap", "film_*", "*_force", "dissipated")
)
SLIDER = ("bodies/slider/x", "bodies/slider/vx", "bodies/slider/ax", *CRANK, *ENERGY)


@dataclass(frozen=True)
class Trajectory:
    """A run whose channels are compared sample by sample.

    length: turns=... or until=... of `cl.simulate`; channels: patterns; by: a stepper or
        "multipliers" (energies by the default stepper then); share: largest deviation allowed, of
        the largest value among the channels of a group that have the same units; energy: the same
        of the energies (default: share); moved: a parameter that must be noticed when it is a
        thousandth larger.
    """

    case: str
    parameters: dict
    length: dict
    channels: tuple[str, ...]
    by: str
    share: float
    moved: str
    energy: float | None = None


@dataclass(frozen=True)
class Impacts:
    """A dry run up to where it is reproducible: its first contacts, column by column of the events.

    share: largest deviation allowed, of the column's largest value.
    """

    case: str
    parameters: dict
    length: dict
    count: int
    by: str
    share: float
    moved: str


@dataclass(frozen=True)
class Statistics:
    """A long dry run: means and standard deviations of its metrics over runs whose tolerances are a
    little apart.
    """

    case: str
    parameters: dict
    length: dict
    names: tuple[str, ...]


@dataclass(frozen=True)
class Estimation:
    """Friction parameters of the ball joint from the synthetic bench of seed 0; share: of the
    values.

    options: of the model, given where the number of its parameters hangs on them.
    """

    model: str
    share: float
    options: dict = field(default_factory=dict)


DRY = {"model": "dry"}
MIXED = {"model": "mixed", "viscosity": 5e-3, "transition": "load_sharing"}
RUNS = {
    "six_bar_feeder_ideal": Trajectory(
        "six_bar_feeder",
        {"model": "ideal"},
        {"turns": 1},
        (*SLIDER, *PINS),
        "multipliers",
        1e-12,
        "speed",
        2e-8,
    ),
    "six_bar_feeder_lubricated_b": Trajectory(
        "six_bar_feeder", {}, {"turns": 2}, (*SLIDER, *JOURNAL, *PINS), "radau9", 2e-5, "clearance"
    ),
    "six_bar_feeder_lubricated_bce": Trajectory(
        "six_bar_feeder",
        {"joints": "B,C,E"},
        {"turns": 2},
        (*SLIDER, *JOURNAL),
        "radau9",
        4e-5,
        "clearance",
    ),
    "six_bar_feeder_load_sharing": Trajectory(
        "six_bar_feeder", MIXED, {"turns": 2}, (*SLIDER, *JOURNAL), "radau9", 2e-5, "viscosity"
    ),
    "six_bar_feeder_fuzzy": Trajectory(
        "six_bar_feeder",
        MIXED | {"transition": "fuzzy"},
        {"turns": 2},
        (*SLIDER, *JOURNAL),
        "radau9",
        2e-4,
        "viscosity",
    ),
    "six_bar_feeder_impacts": Impacts(
        "six_bar_feeder", DRY, {"turns": 0.5}, 6, "radau9", 1e-4, "clearance"
    ),
    "six_bar_feeder_dry": Statistics(
        "six_bar_feeder",
        DRY,
        {"turns": 40},
        (
            "joint_B_force_rms",
            "joint_B_impacts_per_turn",
            "joint_B_contact_fraction",
            "joint_B_dissipated_per_turn",
            "drive_crank_torque_rms",
            "slider_acceleration_max",
        ),
    ),
    "slider_crank_ideal": Trajectory(
        "slider_crank",
        {"model": "ideal"},
        {"turns": 1},
        (*SLIDER, *PINS),
        "multipliers",
        1e-12,
        "speed",
        4e-9,
    ),
    "slider_crank_lubricated": Trajectory(
        "slider_crank",
        {"model": "lubricated"},
        {"turns": 3},
        (*SLIDER, *JOURNAL, *PINS),
        "radau9",
        1e-4,
        "viscosity",
    ),
    "slider_crank_impacts": Impacts(
        "slider_crank", DRY, {"until": 2.5e-3}, 5, "radau9", 4e-5, "clearance"
    ),
    "slider_crank_dry": Statistics(
        "slider_crank",
        DRY,
        {"turns": 60},
        (
            "joint_C_force_rms",
            "joint_C_impacts_per_turn",
            "joint_C_contact_fraction",
            "joint_C_dissipated_per_turn",
            "drive_crank_torque_rms",
            "slider_acceleration_max",
        ),
    ),
    "wear_a": Trajectory(
        "wear_a",
        {"restitution": 0.9},
        {"turns": 0.1},
        (*SLIDER, *JOURNAL, "joints/*/normal_load", "joints/*/wear_volume_bearing"),
        "radau9",
        1e-3,
        "clearance",
    ),
    "four_bar_ideal": Trajectory(
        "four_bar",
        {},
        {"turns": 1},
        ("bodies/rocker/*", *CRANK, *ENERGY, *PINS),
        "multipliers",
        1e-12,
        "speed",
        2e-7,
    ),
    "four_bar_lubricated": Trajectory(
        "four_bar",
        {"model": "lubricated"},
        {"turns": 2},
        ("bodies/rocker/*", *CRANK, *ENERGY, *JOURNAL),
        "radau9",
        1e-4,
        "viscosity",
    ),
    "four_bar_clearances": Trajectory(
        "four_bar_clearances",
        {},
        {"until": 1.0},
        ("bodies/*/theta", "bodies/*/omega", *CRANK, *ENERGY, "joints/*/eccentricity_?"),
        "radau9",
        2e-5,
        "friction_coefficient",
    ),
    "guide_slider": Trajectory(
        "guide_slider",
        {"tilt_rate": -0.01},
        {"until": 0.02},
        ("bodies/*/theta", "bodies/*/omega", *ENERGY, "joints/guide/offset", "joints/guide/tilt"),
        "radau9",
        4e-4,
        "clearance",
    ),
    "double_pendulum": Trajectory(
        "double_pendulum",
        {},
        {"until": 1.5},
        ("bodies/*", "joints/*", *ENERGY),
        "radau9",
        2e-4,
        "length",
    ),
    "double_pendulum_damped": Trajectory(
        "double_pendulum",
        {"damping": 0.05},
        {"until": 2.0},
        ("bodies/*", *ENERGY),
        "radau9",
        5e-5,
        "damping",
    ),
    "five_axis_chain": Trajectory(
        "five_axis_chain",
        {},
        {"until": 5.0},
        ("bodies/link5/theta", "drives/*", *ENERGY, *PINS),
        "multipliers",
        1e-12,
        "coefficient",
        1e-9,
    ),
    # efforts left out: the controllers multiply errors of the angles
    "five_axis_chain_forward": Trajectory(
        "five_axis_chain",
        {"drive": "torque"},
        {"until": 2.0},
        ("bodies/link5/theta", "bodies/link5/omega", "joints/*/friction*", *ENERGY),
        "dop853",
        1e-5,
        "pin_radius",
        4e-5,
    ),
    "three_loop_chain": Trajectory(
        "three_loop_chain",
        {"where": "all"},
        {"until": 10.0},
        ("bodies/link_c/theta", "drives/*", *ENERGY, *PINS),
        "multipliers",
        1e-12,
        "coefficient",
        2e-6,
    ),
    "three_loop_chain_forward": Trajectory(
        "three_loop_chain",
        {"drive": "torque", "where": "all"},
        {"until": 5.0},
        ("bodies/link_c/*", "drives/*", *ENERGY, "joints/*/friction"),
        "dop853",
        1e-4,
        "coefficient",
    ),
    "mobile_manipulator": Trajectory(
        "mobile_manipulator",
        {},
        {"until": 15.0},
        ("bodies/bucket/*", "drives/*/force", *ENERGY, "joints/J?/force_?"),
        "multipliers",
        1e-12,
        "load_x",
        2e-7,
    ),
    "ball_joint_curve": Estimation("curve", 1e-9, {"knots": KNOTS}),
    # the fit stops where a pass changes the cost by 1e-9, in a valley along which a Stribeck speed
    # moves by 5e-4
    "ball_joint_lugre1d": Estimation("lugre1d", 2e-3),
    "ball_joint_lugre3d": Estimation("lugre3d", 2e-3),
}

Run = Trajectory | Impacts | Statistics | Estimation
Tables = dict[str, dict[str, np.ndarray]]


# --- results
def scene_of(run: Run, factor: float = 1.0) -> cl.Scene:
    """The scene of a run; factor: what its `moved` parameter is multiplied by."""
    parameters = dict(run.parameters)
    if factor != 1.0:
        reference = find_case(run.case).parameters
        parameters[run.moved] = factor * parameters.get(run.moved, reference[run.moved].default)
    return cl.load_case(run.case, **parameters)


def stored(record, patterns: tuple[str, ...]) -> list[str]:
    """Paths of the channels that one of the patterns names."""
    groups = [
        f"{kind}/{name}"
        for kind in ("bodies", "joints", "drives", "springs")
        for name in record.names(kind)
    ]
    paths = [
        f"{group}/{channel}" for group in (*groups, "energy") for channel in record.names(group)
    ]
    return [p for p in paths if any(fnmatchcase(p, pattern) for pattern in patterns)]


def channels(run: Trajectory, record, energies=None) -> Tables:
    """The samples of a run's channels; energies: the record that has them, if it is another."""
    energies = energies or record
    paths = stored(energies, run.channels)
    sources = {p: energies if p.startswith("energy/") else record for p in paths}
    return {
        "samples": {"values": np.stack([sources[p].values(p) for p in paths], axis=1)},
        "channels": {"path": paths, "units": [sources[p].units(p) for p in paths]},
    }


def contacts(run: Impacts, record) -> Tables:
    """The first contacts; raises ValueError where there are fewer."""
    events = record.events
    if len(events["time"]) < run.count:
        raise ValueError(
            f"{run.case}: {len(events['time'])} contacts, expected at least {run.count}"
        )
    return {"contacts": {column: events[column][: run.count] for column in COLUMNS}}


def sums(run: Statistics, rtol: float = 1e-6) -> np.ndarray:
    """The metrics of a long run, in the order of `names`."""
    actual = metrics(
        cl.simulate(scene_of(run), samples_per_turn=200, rtol=rtol, energy=True, **run.length)
    )
    return np.array([actual[name].value for name in run.names])


def estimated(run: Estimation, starts: int = 1) -> Tables:
    """Values of the parameters and errors by role."""
    actual = fit(bench(seed=0), model(run.model, **run.options), starts=starts)
    return {
        "parameters": {
            "name": list(actual.values),
            "value": np.array(list(actual.values.values())),
        },
        "nrmse": {"role": list(actual.nrmse), "value": np.array(list(actual.nrmse.values()))},
    }


def result(run: Run, factor: float = 1.0) -> Tables:
    """Quantities that a test compares: the run with default settings (of statistics: one draw)."""
    match run:
        case Trajectory():
            return channels(run, cl.simulate(scene_of(run, factor), samples=SAMPLES, **run.length))
        case Impacts():
            return contacts(run, cl.simulate(scene_of(run, factor), samples=2, **run.length))
        case Statistics():
            return {"metrics": {"name": list(run.names), "value": sums(run)}}
        case Estimation():
            return estimated(run)


def reference(run: Run) -> tuple[Tables, dict]:
    """The better result, and what it was made by."""
    match run:
        case Trajectory(by="multipliers"):
            scene = scene_of(run)
            record = cl.inverse_dynamics(scene, samples=SAMPLES, **run.length)
            energies = cl.simulate(scene, samples=SAMPLES, rtol=TIGHT, **run.length)
            tables = channels(run, record, energies)
            poses = pinocchio.states(scene, record)[:, :-1, :3]
            outputs = inverse(scene, record.time, poses)
            columns = tables["samples"]["values"].T
            for path, column in zip(tables["channels"]["path"], columns, strict=True):
                column[:] = outputs.get(path, column)
            return tables, {
                "made_by": "multipliers; energies dop853",
                "rtol": TIGHT,
            }
        case Trajectory():
            record = cl.simulate(
                scene_of(run), samples=SAMPLES, rtol=TIGHT, method=run.by, **run.length
            )
            return channels(run, record), {"made_by": run.by, "rtol": TIGHT}
        case Impacts():
            record = cl.simulate(scene_of(run), samples=2, rtol=TIGHT, method=run.by, **run.length)
            return contacts(run, record), {"made_by": run.by, "rtol": TIGHT}
        case Statistics():
            draws = np.array([sums(run, 1e-7 * (1.0 + 0.1 * k)) for k in range(DRAWS)])
            table = {
                "name": list(run.names),
                "value": draws.mean(axis=0),
                "deviation": draws.std(axis=0, ddof=1),
            }
            return {"metrics": table}, {"made_by": f"{DRAWS} runs", "rtol": 1e-7}
        case Estimation():
            return estimated(run, starts=20), {"made_by": "best of 20 starts", "rtol": 0.0}


# --- comparison
def deviations(run: Run, actual: Tables, reference: Tables) -> dict[str, float]:
    """Deviation over what is allowed, by channel, column, metric or parameter: at most 1 where all
    is well.

    Raises ValueError where the two do not hold the same channels, metrics or parameters.
    """
    for table, column in (
        ("channels", "path"),
        ("metrics", "name"),
        ("parameters", "name"),
        ("nrmse", "role"),
    ):
        if table in reference and sorted(actual[table][column]) != sorted(reference[table][column]):
            raise ValueError(
                f"{table}: found {actual[table][column]}, "
                f"the reference has {reference[table][column]}"
            )
    match run:
        case Trajectory():
            return _of_channels(run, actual, reference)
        case Impacts():
            pairs = {
                c: (actual["contacts"][c], values) for c, values in reference["contacts"].items()
            }
            return {
                c: np.abs(a - b).max() / (run.share * np.abs(b).max())
                for c, (a, b) in pairs.items()
            }
        case Statistics():
            spread = SIGMAS * reference["metrics"]["deviation"]
            off = np.abs(actual["metrics"]["value"] - reference["metrics"]["value"]) / spread
            return dict(zip(run.names, off.tolist(), strict=True))
        case Estimation():
            off = {}
            for table, column in (("parameters", "name"), ("nrmse", "role")):
                a, b = actual[table]["value"], reference[table]["value"]
                share = np.abs(a - b) / (
                    run.share * np.abs(b).max() if run.model == "curve" else run.share * np.abs(b)
                )
                off |= dict(zip(reference[table][column], share.tolist(), strict=True))
            return off


def _of_channels(run: Trajectory, actual: Tables, reference: Tables) -> dict[str, float]:
    """Each channel against the largest value among those of its group that have its units."""
    column = {p: i for i, p in enumerate(actual["channels"]["path"])}
    paths, values = reference["channels"]["path"], reference["samples"]["values"]
    kinds = [
        (p.rpartition("/")[0], units)
        for p, units in zip(paths, reference["channels"]["units"], strict=True)
    ]
    sizes: dict = {}
    for kind, largest in zip(kinds, np.abs(values).max(axis=0), strict=True):
        sizes[kind] = max(sizes.get(kind, 0.0), largest)
    off = {}
    for i, (path, kind) in enumerate(zip(paths, kinds, strict=True)):
        share = run.energy if run.energy and kind[0] == "energy" else run.share
        far = np.abs(actual["samples"]["values"][:, column[path]] - values[:, i]).max()
        off[path] = far / (share * sizes[kind]) if sizes[kind] else far
    return off


# --- files
_UNITS = {
    "values": "see channels/units",
    "value": "SI, by name",
    "deviation": "SI, by name",
    "time": "s",
    "impact_speed": "m/s",
    "peak_force": "N",
    "peak_penetration": "m",
    "duration": "s",
}


def path_of(name: str) -> Path:
    return FOLDER / f"{name}.h5"


def described(run: Run) -> str:
    """The run's scene and options as JSON, without the parts that may differ."""
    return json.dumps(
        {n: v for n, v in asdict(run).items() if n not in ("share", "energy", "moved")}
    )


def save(name: str) -> dict[str, float]:
    """Make the reference of a run and write its file; returns the deviations of the run with
    default settings.
    """
    run = RUNS[name]
    tables, facts = reference(run)
    off = deviations(run, result(run), tables)
    facts |= {"run": described(run), "kind": type(run).__name__, "off": max(off.values())}
    groups = {
        t: ({}, {c: (_UNITS.get(c, "1"), c, v) for c, v in columns.items()})
        for t, columns in tables.items()
    }
    save_tables(path_of(name), FORMAT, {"format_version": FORMAT_VERSION, **facts}, groups)
    return off


def read(name: str) -> tuple[Tables, dict]:
    """The tables of a reference and its facts.

    Raises FileNotFoundError or ValueError for what is no such file.
    """
    with open_checked(path_of(name), "clearance reference", FORMAT, FORMAT_VERSION) as file:
        facts = file.attributes()
        tables = {
            t: {c: _listed(file.column(f"{t}/{c}")) for c in file.names(t)} for t in file.names()
        }
    return tables, facts


def _listed(values: np.ndarray):
    return values.tolist() if values.dtype.kind == "U" else values


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="make references of the regression tests")
    parser.add_argument(
        "names", metavar="NAME", nargs="*", help=f"of {', '.join(RUNS)} (default all)"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace files that are there")
    options = parser.parse_args(arguments)
    names = options.names or list(RUNS)
    if unknown := [n for n in names if n not in RUNS]:
        parser.error(f"no reference {unknown[0]!r}; there are {', '.join(RUNS)}")
    if there := [n for n in names if path_of(n).exists() and not options.overwrite]:
        parser.error(f"{path_of(there[0])} exists; give --overwrite to replace it")
    for name in names:
        off = save(name)
        worst, size = max(off, key=off.get), path_of(name).stat().st_size / 1e3
        print(
            f"{name}: {size:.0f} kB; default settings off by {off[worst]:.2g} of what is allowed "
            f"({worst})"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
