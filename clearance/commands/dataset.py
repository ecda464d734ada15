"""`clearance dataset`: labelled records of a case, with the noise of a sensor."""

from pathlib import Path

from clearance.commands.common import (
    case_of,
    case_options,
    seed_of,
    show,
    taken,
    texts_of,
)
from clearance.commands.fit import lowpass
from clearance.commands.sweep import going_on

EXAMPLES = """\
-p NAME=LOW:HIGH or LOW:HIGH:log is drawn, -p NAME=VALUE holds. Without ranges clearance, viscosity
and speed are drawn within a factor of 2 of their defaults.

  clearance dataset slider_crank -p model=lubricated --channels bodies/slider/ax --points 1000 \\
    --seed 7 -o set
"""


OPTIONS = case_options(
    "NAME=LOW:HIGH", "a parameter that is drawn, or NAME=VALUE, one that holds"
) | {
    "--channels PATHS !": "of each record: comma list",
    "--points N": (1000, "records"),
    "--seed N": (0, "of draw and noise"),
    "--turns N": (2, "of a record"),
    "--settle N": (2, "turns before it"),
    "--samples-per-turn N": (360, "of a record"),
    "--noise X": ("1%", "in SI, or of the range"),
    "--lowpass ORDER:CORNER": "filter of the sensor, as 2:1000",
    "--mounting X": ("0deg", "deviation of sensor angles"),
    "--workers N": (int, None, "processes (default one a core)"),
    "--baseline N": (int, None, "fit the first N records, add scores"),
    "--quiet": "no progress and no summary",
    "-o DIR": "folder (default CASE_dataset)",
}


def run(options) -> int:
    """Make the records and print where they are."""
    from clearance.sweeping.dataset import dataset
    from clearance.sweeping.points import range_from_words

    case, ranges, fixed = case_of(options), {}, {}
    for name, text in texts_of(options, case.parameters).items():
        parameter = case.parameters[name]
        if ":" in text:
            ranges[name] = range_from_words(parameter, text)
        else:
            fixed[name] = parameter.value(text)
    folder = Path(options.output or f"{case.name}_dataset")
    with going_on(options) as shown:
        path = dataset(
            options.case,
            folder,
            options.channels,
            ranges=ranges,
            fixed=fixed,
            seed=seed_of(options),
            lowpass=lowpass(options.lowpass),
            progress=shown,
            **taken(options, "mounting points turns settle samples_per_turn noise workers"),
        )
    scores = {}
    if options.baseline:
        from clearance.identify.baseline import baseline
        from clearance.sweeping.dataset import scored

        scores = baseline(path, options.baseline)
        scored(folder, scores)
    files = {"status": "complete", "records": str(path), "card": str(path.with_name("card.md"))}
    files |= {"baseline": scores} if scores else {}
    card = path.with_name("card.md").read_text(encoding="utf-8")
    return show(options, files, [card, f"wrote {path} ({path.stat().st_size / 1e6:.3g} MB)"])
