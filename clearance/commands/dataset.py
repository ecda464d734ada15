"""`clearance dataset`: labelled records of a case, with the noise of a sensor."""

import argparse
from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    add_case,
    add_command,
    complain,
    given,
    json_text,
    seed_of,
    taken,
)
from clearance.commands.fit import lowpass
from clearance.commands.sweep import begin
from clearance.run.interrupts import terminable

EXAMPLES = """\
-p NAME=LOW:HIGH or LOW:HIGH:log is drawn, -p NAME=VALUE holds. Without ranges clearance, viscosity
and speed are drawn within a factor of 2 of their defaults.

  clearance dataset slider_crank -p model=lubricated --channels bodies/slider/ax --points 1000 \\
    --seed 7 -o set
"""


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "dataset", epilog=EXAMPLES)
    add_case(p, "NAME=LOW:HIGH", "a parameter that is drawn, or NAME=VALUE, one that holds")
    p.add_argument("--channels", required=True, metavar="PATHS", help="of each record: comma list")
    p.add_argument("--points", type=int, default=1000, metavar="N", help="records (default 1000)")
    p.add_argument("--seed", type=int, default=0, metavar="N", help="of draw and noise (0)")
    p.add_argument("--turns", type=int, default=2, metavar="N", help="of a record (default 2)")
    p.add_argument("--settle", type=int, default=2, metavar="N", help="turns before it (2)")
    p.add_argument(
        "--samples-per-turn", type=int, default=360, metavar="N", help="of a record (360)"
    )
    p.add_argument("--noise", default="1%", metavar="X", help="in SI, or of the range (1%%)")
    p.add_argument("--lowpass", metavar="ORDER:CORNER", help="filter of the sensor, as 2:1000")
    p.add_argument("--mounting", default="0deg", metavar="X", help="deviation of sensor angles (0)")
    p.add_argument("--workers", type=int, metavar="N", help="processes (default one a core)")
    p.add_argument("--baseline", type=int, metavar="N", help="fit the first N records, add scores")
    p.add_argument("--quiet", action="store_true", help="no progress and no summary")
    p.add_argument("-o", dest="output", metavar="DIR", help="folder (default CASE_dataset)")
    return p


def run(options) -> int:
    """Make the records and print where they are."""
    from clearance.scene.catalogue import find_case
    from clearance.sweeping.dataset import dataset
    from clearance.sweeping.points import range_from_words
    from clearance.sweeping.sweep import SweepError

    case, ranges, fixed = find_case(options.case), {}, {}
    for name, text in given(options, case.parameters).items():
        parameter = case.parameters[name]
        if ":" in text:
            ranges[name] = range_from_words(parameter, text)
        else:
            fixed[name] = parameter.value(text)
    folder, shown = Path(options.output or f"{case.name}_dataset"), begin(options)
    try:
        with terminable():
            path = dataset(
                options.case,
                folder,
                options.channels,
                ranges=ranges,
                fixed=fixed,
                seed=seed_of(options),
                lowpass=lowpass(options.lowpass),
                mounting=options.mounting,
                progress=shown,
                **taken(options, "points turns settle samples_per_turn noise workers"),
            )
    except SweepError as error:
        return complain(options, str(error), FAILED)
    except KeyboardInterrupt:
        return complain(options, "interrupted; the same command goes on where this stopped", FAILED)
    finally:
        shown.close()
    scores = {}
    if options.baseline:
        from clearance.identify.baseline import baseline
        from clearance.sweeping.dataset import scored

        scores = baseline(path, options.baseline)
        scored(folder, scores)
    files = {"status": "complete", "records": str(path), "card": str(path.with_name("card.md"))}
    files |= {"baseline": scores} if scores else {}
    if options.json:
        print(json_text(files))
    elif not options.quiet:
        print(path.with_name("card.md").read_text(encoding="utf-8"))
        print(f"wrote {path} ({path.stat().st_size / 1e6:.3g} MB)")
    return DONE
