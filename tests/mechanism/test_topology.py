"""The order in which a mechanism is solved: the sets of bodies that their equations determine."""

import random
from itertools import combinations

import pytest

import clearance as cl
from clearance.mechanism import topology
from clearance.mechanism.topology import COORDINATES, Sharing
from tests import mechanisms as m
from tests.seeds import few_of


def ladder(windows: int, driven: bool = False) -> cl.Scene:
    """Four-bars in a row on common rockers, 2 windows + 1 bodies; nothing drives them."""
    rockers = [
        m.body(f"rocker{i}", {"p": (0, 0), "q": (0.05 if i == 0 else 0.12, 0)}, 1.1)
        for i in range(windows + 1)
    ]
    parts = [
        cl.Revolute(cl.ground.at(0.2 * i, 0), r["p"], name=f"O{i}") for i, r in enumerate(rockers)
    ]
    for i in range(windows):
        coupler = m.body(f"coupler{i}", {"p": (0, 0), "q": (0.2, 0)})
        parts.append(cl.Revolute(rockers[i]["q"], coupler["p"], name=f"A{i}"))
        parts.append(cl.Revolute(coupler["q"], rockers[i + 1]["q"], name=f"B{i}"))
    return cl.Scene(*parts, *([cl.Drive(rockers[0], speed=1.0)] if driven else []), name="ladder")


@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("windows", [10, 20, 40])
def test_M2_ladders(windows, driven):
    """One body by its free or driven angle, then a dyad for each window.

    Bodies looked at grow with the square of the windows (6 windows^2); subsets tried grew with the
    eighth power.
    """
    scene = ladder(windows, driven)
    planner = topology._Planner(scene, scene.joints)
    plan = planner.run()
    assert [g.form for g in plan.groups] == ["tree", *["RRR"] * windows]
    actual = [{a.body.name for a in g.attachments} for g in plan.groups]
    assert actual == [{"rocker0"}, *({f"coupler{i}", f"rocker{i + 1}"} for i in range(windows))]
    assert len(plan.free) == (0 if driven else 1)
    assert planner.sharing.visits < 10 * windows**2


def tried(bodies, equations):
    """The smallest determined set, by trying all subsets."""
    for size in range(1, len(bodies) + 1):
        for some in combinations(bodies, size):
            inside = sum(set(ends) <= set(some) for ends in equations)
            if inside >= COORDINATES * size:
                return frozenset(some)
    return None


@pytest.mark.parametrize("seed", few_of(range(40), 10))
def test_M2_as_all_subsets(seed):
    """The same smallest set as by trying them all, at every stage, where no equations repeat each
    other.
    """
    draw = random.Random(seed)
    bodies = list(range(draw.randint(2, 8)))
    pairs = [draw.choice([(b,), tuple(draw.sample(bodies, 2))]) for b in bodies for _ in range(2)]
    equations = [ends for pair in pairs for ends in draw.choice([1, 2]) * [pair]]
    while sum(map(len, (sharing := Sharing(bodies, equations)).held.values())) < len(equations):
        equations.pop(draw.randrange(len(equations)))
    while bodies:
        actual = sharing.smallest()
        assert actual == tried(bodies, equations)
        placed = actual or {bodies[0]}
        bodies = [b for b in bodies if b not in placed]
        equations = [tuple(e for e in ends if e not in placed) for ends in equations]
        equations = [ends for ends in equations if ends]
        sharing.settle(placed)
        if sum(map(len, sharing.held.values())) < len(equations):
            return  # the body put in place freely had equations to meet


def test_redundant_loop_keeps_small_groups():
    """Three parallel cranks under a beam: one equation too many changes nothing of the groups
    before it.
    """
    plan = topology.closed_plan(m.parallelogram())
    assert [g.label() for g in plan.groups] == ["one", "beam+two", "three"]
