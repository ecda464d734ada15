"""`clearance bench-data`: measurements of a synthetic test bench."""

from pathlib import Path

from clearance.commands.common import listed, seed_of, show
from clearance.values.units import quantity

OPTIONS = {
    "joint": {"metavar": "JOINT", "choices": ["ball_joint"], "help": "ball_joint"},
    "-o FILE": "measurement, .h5 or .csv (default ball_joint.h5)",
    "--seed N": (0, "of scatter and noise, 0 is nearest the source"),
    "--scatter X": (0.16, "of the level from run to run"),
    "--preload LIST": ("5000", "preloads [N], each with the complete programme: 2000,5kN"),
    "--noise X": (0.02, "of the torque in N m"),
}


def run(options) -> int:
    """Make the data, write them and print what they are."""
    from clearance.identify.records import write
    from clearance.paper_figures.ball_joint_bench import bench

    path = Path(options.output or f"{options.joint}.h5")
    if path.suffix.lower() not in (".h5", ".hdf5", ".csv"):
        raise ValueError(f"-o {path}: a measurement's name must end in .h5, .hdf5 or .csv")
    preloads = [quantity(part, "N") for part in listed(options.preload) or ()]
    measurement = bench(seed_of(options), options.scatter, options.noise, preloads=preloads)
    write(path, measurement)
    roles = {
        r: {"trials": len((of := measurement.of(r)).trials), "samples": of.samples}
        for r in measurement.roles
    }
    document = {"status": "complete", "file": str(path), "facts": measurement.facts, "roles": roles}
    rows = (
        f"  {r:<14} {n['trials']:>3} trials {n['samples']:>7} samples" for r, n in roles.items()
    )
    head = f"{measurement.facts['title']}, seed {options.seed}: nothing of it was measured"
    return show(options, document, [head, *rows, f"  file           {path}"])
