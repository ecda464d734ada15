"""`clearance explain`: what a compiled scene contains, and what was left out."""

import argparse
import textwrap

from clearance.commands.common import (
    DONE,
    Line,
    add_case,
    add_command,
    add_options,
    json_text,
    scene_of,
)


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "explain")
    add_case(p)
    return add_options(p, {"--cost": "also measure what each part of such a scene costs"})


def run(options) -> int:
    """Build the scene and print what was compiled."""
    from clearance.paper_figures import ablation
    from clearance.studies.explain import explain

    case, values, scene = scene_of(options)
    parts = ablation.ablation(scene, options.cost, Line(options))
    report = {"parameters_given": values, **explain(scene), "cost": ablation.plain(parts)}
    if options.json:
        print(json_text(report))
        return DONE
    print(f"{case.name}: {len(report['bodies'])} bodies, {len(report['states'])} states")
    for name in report["states"]:
        print(f"  state      {name}")
    for name, joint in report["joints"].items():
        laws = ", ".join(f"{k} {v}" for k, v in joint.items() if k not in ("kind", "reality"))
        print(f"  joint {name:<4} {joint['reality']} {joint['kind']}{': ' + laws if laws else ''}")
    for group in report["plan"]:
        print(f"  position   {group['bodies']} {group['solved']}")
    for role, k in report["kernels"].items():
        calls = f", calls {', '.join(k['calls'])}" if k["calls"] else ""
        print(f"  kernel     {role}: {k['operations']} operations{calls}")
    print(
        f"  numbers    {report['parameters']} parameters, {report['derived_parameters']} derived "
        f"from them"
    )
    print(f"  outputs    {len(report['channels'])} channels")
    print(f"  modules    {len(report['modules'])} imported; --json has their names")
    reason = report["not_in_lanes"]
    way = f"each point by itself: {reason}" if reason else "points side by side, in lanes"
    print(f"  sweeps     {way}")
    reasons = "; ".join(report["not_exported"])
    print(f"  export     {f'impossible: {reasons}' if reasons else 'as C source and as FMU'}")
    print(_listed("left out", report["left_out"]))
    print(f"  store      {report['store']}")
    for warning in report["warnings"]:
        print(f"  warning    {warning}")
    print("\n" + "\n".join(ablation.table(parts)))
    return DONE


def _listed(what: str, items: list[str]) -> str:
    """A line of items, in lines below one another."""
    return textwrap.fill(
        f"  {what:<10} {', '.join(items)}", 110, subsequent_indent=13 * " ", break_long_words=False
    )
