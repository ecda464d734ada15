"""`clearance bench-data`: measurements of a synthetic test bench."""

import argparse
from pathlib import Path

from clearance.commands.common import DONE, add_command, json_text, listed, number, seed_of
from clearance.values.units import quantity


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "bench-data")
    p.add_argument("joint", metavar="JOINT", choices=["ball_joint"], help="ball_joint")
    p.add_argument(
        "-o", dest="output", metavar="FILE", help="measurement, .h5 or .csv (default ball_joint.h5)"
    )
    p.add_argument(
        "--seed",
        type=int,
        default=0,
        metavar="N",
        help="of scatter and noise (0, nearest the source)",
    )
    p.add_argument(
        "--scatter",
        type=number,
        default=0.16,
        metavar="X",
        help="of the level from run to run (0.16)",
    )
    p.add_argument(
        "--preload",
        default="5000",
        metavar="LIST",
        help="preloads [N], each with the complete programme: 2000,5kN (5000)",
    )
    p.add_argument(
        "--noise", type=number, default=0.02, metavar="X", help="of the torque in N m (0.02)"
    )
    return p


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
    if options.json:
        print(
            json_text(
                {
                    "status": "complete",
                    "file": str(path),
                    "facts": measurement.facts,
                    "roles": roles,
                }
            )
        )
        return DONE
    print(f"{measurement.facts['title']}, seed {options.seed}: nothing of it was measured")
    for role, n in roles.items():
        print(f"  {role:<14} {n['trials']:>3} trials {n['samples']:>7} samples")
    print(f"  file           {path}")
    return DONE
