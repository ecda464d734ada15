"""Cost of each part of a scene, saved by leaving it out.

Group: measured

Answers: no figure of a source; it shows that a scene pays only for what it has.

Reproduced: states, operations of a right-hand side, output channels and time of a step of the
feeder with three mixed joints. Then one part after the other is left out.

Assumed: set feeder-A, one crank turn, CPU time of one core, warm; medians and ranges of nine
repeats in turn.

Not comparable: times of another machine, only ratios. On a busy machine the picture states how far
repeats differ.
"""

import numpy as np
from clearance.paper_figures import ablation, workshop
from clearance.postprocess.figures import finish, sheet, stroke

import clearance as cl
from clearance.results.tables import save_tables

PARAMETERS = {"model": "mixed", "joints": "B,C,E"}


def draw(work: workshop.Workshop) -> None:
    parameters = PARAMETERS | work.less({}, {"model": "lubricated", "joints": "B"})
    rows = ablation.ablation(cl.load_case("six_bar_feeder", **parameters), progress=work.say)
    work.keep(costs(rows))
    work.text(ablation.table(rows))
    work.study(lambda folder: _save(rows, folder), case="six_bar_feeder", parameters=parameters)


def costs(rows):
    """Operations, channels and time of a step of each scene, as bars."""
    figure = sheet(11.0, 1.0 + 0.45 * len(rows))
    panels = figure.subplots(1, 3, sharey=True, width_ratios=(1, 1, 1.6))
    level = np.arange(len(rows))[::-1]
    for axes, name, label in (
        (panels[0], "operations", "operations a right-hand side"),
        (panels[1], "channels", "output channels"),
    ):
        bars = axes.barh(level, [getattr(r, name) for r in rows], color="0.55")
        axes.bar_label(bars, fontsize=7, padding=2)
        axes.margins(x=0.18)
        finish(axes, "", label)
    parts = {
        "equations and laws": "step",
        "with energy ledger": "ledger_step",
        "with all outputs too": "output_step",
    }
    for i, (label, name) in enumerate(parts.items()):
        time = 1e6 * np.array([getattr(r, name) for r in rows])
        low, high = 1e6 * np.array([r.ranges[name] for r in rows]).T
        style = {
            "color": stroke(i, 3)["color"],
            "ecolor": "0.5",
            "error_kw": {"lw": 0.8, "capsize": 1.5},
        }
        panels[2].barh(
            level + 0.27 * (1 - i), time, 0.25, xerr=(time - low, high - time), label=label, **style
        )
    panels[2].margins(x=0.03)
    finish(panels[2], "", "CPU time of a step [us]; lines: range of the repeats")
    figure.suptitle(ablation.doubt(rows), fontsize="medium", color="#b03a00")
    for axes in panels:
        axes.set_axisbelow(True)
    panels[0].set_yticks(level, [r.name for r in rows], fontsize=8)
    return figure


def _save(rows, folder):
    columns = {
        "name": ("1", "scene", [r.name for r in rows]),
        "operations": (
            "1",
            "of a right-hand side, laws not counted",
            np.array([r.operations for r in rows]),
        ),
        "channels": ("1", "output channels", np.array([r.channels for r in rows])),
        "states": ("1", "first-order states", np.array([r.states for r in rows])),
        "step": ("s", "time of a step", np.array([r.step for r in rows])),
        "ledger_step": (
            "s",
            "time of a step with energy ledger",
            np.array([r.ledger_step for r in rows]),
        ),
        "output_step": (
            "s",
            "time of a step with ledger and outputs",
            np.array([r.output_step for r in rows]),
        ),
    }
    for i, end in enumerate(("smallest", "largest")):
        for name in ablation.TIMES:
            columns[f"{name}_{end}"] = (
                "s",
                f"{end} of the repeats",
                np.array([r.ranges[name][i] for r in rows]),
            )
    return save_tables(folder / "ablation.h5", "clearance-ablation", {}, {"parts": ({}, columns)})
