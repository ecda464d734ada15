"""`clearance plot`: pictures of run files and of sweeps."""

from clearance.commands.common import number, show
from clearance.postprocess.pictures import (
    FRAMES,
    OF_LIVES,
    OF_RUNS,
    OF_SEVERAL,
    OF_SWEEPS,
    drawn,
)
from clearance.postprocess.pictures import Pictures as Pictures

EXAMPLES = """\
  clearance plot run.h5                                            overview
  clearance plot run.h5 history --channels "slider.ax,C.force" --along angle --last 1 \\
    -o last_turn.pdf
  clearance plot dry.h5 lubricated.h5 phase --channels slider.x,slider.vx --settle 2
  clearance plot arm.h5 friction --joint shoulder,elbow -o friction.pdf
  clearance plot film.h5 pressure --joint B  # of a run with --pressure-fields N
  clearance plot run.h5 tornado --metrics "joint_B_*"  # of a run with --sensitivity NAMES
  clearance plot run.h5 --measured bench.csv --channels slider.ax=a  # column a beside the run
  clearance plot run.h5 animation --turns 2 --frames 100 -o run.gif
  clearance plot SWEEP map --metrics "joint_*_force_max,period" --x speed --y clearance \\
    --at model=dry
  clearance plot SWEEP bifurcation --x speed --channels slider.vx --settle 100
  clearance plot SCATTER --metrics "joint_*_gap_min"  # a directory of `clearance scatter`
  clearance plot WORN; clearance plot WORN animation -o life.gif  # of `clearance wear`

Channels are paths, short names or patterns (bodies/slider/ax, slider.ax, "*.force"); phase and
poincare take them two by two. Without KIND: the overview of a run, the map of a grid, the scatter
of a scatter, the curves of other sweeps.
"""


USAGE = "clearance plot FILE_OR_DIR [MORE_FILES ...] [KIND] [options] [-o PICTURE]"
OPTIONS = {
    "inputs FILE_OR_DIR +": f"run file, several of them ({', '.join(OF_SEVERAL)}), or sweep "
    f"directory; then the KIND of picture. Of runs: {', '.join(OF_RUNS)}; of sweeps: "
    f"{', '.join(OF_SWEEPS)}; of lives: {', '.join(OF_LIVES)}",
    "--only-settled": {
        "action": "store_true",
        "default": None,
        "help": "leave out points whose motion did not come back to itself within the run: map, "
        "curves",
    },
    "--at": {
        "action": "append",
        "metavar": "NAME=VALUE",
        "help": "hold a swept parameter at the value nearest to this: map, curves, bifurcation; "
        "may be repeated",
    },
    "--channels NAMES": "comma list of channels: history, phase, poincare, spectrum, bifurcation",
    "--joint NAMES": "comma list of clearance joints: orbit, contacts, guide; one: poincare, "
    "pressure; of hinges and slides with friction: friction",
    "--surface NAME": "bearing or journal: life",
    "--along ALONG": "time, turns or angle of the drive: history",
    "--last TURNS": (number, None, "only the last turns: history"),
    "--measured FILE.csv": "measured data over time or drive angle, with units in the header, "
    "to lay over a channel of --channels, CHANNEL or CHANNEL=COLUMN",
    "--column NAME": "column of the measured data, where there are several",
    "--shift T": "where in the run the measured data begin (default: found)",
    "--settle TURNS": (
        number,
        None,
        "turns left out at the start: phase, spectrum, contacts (default 0), poincare "
        "(default 2), bifurcation (default the first half of the runs)",
    ),
    "--angle ANGLE": ("rad", None, "of the drive, such as 90deg: poincare, bifurcation"),
    "--turns TURNS": (
        number,
        None,
        "last turns shown: animation (default 1); instant shown, in turns from the start: "
        "sketch (default 0)",
    ),
    "--frames N": (int, None, f"animation (default {FRAMES}, or all samples)"),
    "--magnify X": (
        number,
        None,
        "clearances over the mechanism: animation (default as fits)",
    ),
    "--metrics NAMES": "comma list of metrics or patterns: map, curves, scatter, tornado",
    "--x NAME": "parameter along the axis: map, curves, bifurcation",
    "--y NAME": "parameter along the other axis: map",
    "-o PICTURE": "picture (.png, .pdf, .svg; an animation .gif, .mp4); default beside the "
    "input, named after the kind",
}


def run(options) -> int:
    """Draw the picture and print its path.

    Raises ValueError for options that do not belong to it.
    """
    options.facts = {}
    picture = drawn(options, options.inputs)
    sentence = options.facts.pop("sentence", None)
    document = {"status": "complete", "picture": str(picture), **options.facts}
    return show(options, document, filter(None, (sentence, f"wrote {picture}")))
