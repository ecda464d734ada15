"""`clearance explain`: what a compiled scene contains, and what was left out."""

import argparse
import textwrap
from collections import Counter

from clearance.commands.common import DONE, Line, add_case, add_command, json_text, scene_of


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "explain", help="what the compiled scene contains and what was left out")
    add_case(p)
    p.add_argument("--cost", action="store_true", help="also measure what each part of such a scene costs")
    return p


def run(options) -> int:
    """Build the scene and say what it became."""
    from clearance.evidence import ablation
    from clearance.evidence.explain import explain

    case, values, scene = scene_of(options)
    parts = ablation.ablation(scene, options.cost, Line(options))
    found = {"parameters_given": values, **explain(scene), "cost": ablation.plain(parts)}
    if options.json:
        print(json_text(found))
        return DONE
    print(f"{case.name}: {len(found['bodies'])} bodies, {len(found['states'])} states")
    for name in found["states"]:
        print(f"  state      {name}")
    for name, joint in found["joints"].items():
        laws = ", ".join(f"{k} {v}" for k, v in joint.items() if k not in ("kind", "reality"))
        print(f"  joint {name:<4} {joint['reality']} {joint['kind']}{': ' + laws if laws else ''}")
    for group in found["plan"]:
        print(f"  position   {group['bodies']} {group['solved']}")
    for role, k in found["kernels"].items():
        calls = f", calls {', '.join(k['calls'])}" if k["calls"] else ""
        print(
            f"  kernel     {role}: {k['operations']} operations{calls}"
        )
    print(f"  numbers    {found['parameters']} parameters, {found['derived_parameters']} derived from them")
    print(f"  outputs    {len(found['channels'])} channels")
    packages = Counter(".".join(m.split(".")[:2]) for m in found["modules"])
    print(_listed("modules", [f"{name} ({n})" if n > 1 else name for name, n in packages.items()]))
    print(_listed("left out", found["left_out"]))
    print(f"  store      {found['store']}")
    for warning in found["warnings"]:
        print(f"  warning    {warning}")
    print("\n" + "\n".join(ablation.table(parts)))
    return DONE


def _listed(what: str, items: list[str]) -> str:
    """A line of items, in lines below one another."""
    return textwrap.fill(f"  {what:<10} {', '.join(items)}", 110, subsequent_indent=13 * " ", break_long_words=False)
