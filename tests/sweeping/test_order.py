"""Points are handed out once each, far apart at first, then the longest first."""

from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

import clearance as cl
from clearance.sweeping.order import FIRST, Queue


@settings(max_examples=50)
@given(st.integers(1, 300), st.integers(0, 2**32))
def test_every_point_is_handed_out_once(count, seed):
    """Also those that came back with a lost worker."""
    random = Random(seed)
    points = cl.grid(speed=[float(i) for i in range(count)])
    pending = sorted(random.sample(range(count), random.randint(1, count)))
    queue, given_out = Queue(points, pending), []
    while queue:
        index = queue.take()
        if random.random() < 0.1:
            queue.put_back(index)  # lost with its worker
            continue
        given_out.append(index)
        queue.learn(index, random.random())
    assert sorted(given_out) == pending


def test_the_longest_comes_first_once_costs_are_known():
    """First points are spread out; then the dearest model leads."""
    points = cl.grid(speed=[float(i) for i in range(16)], model=["dry", "lubricated"])
    cost = {
        i: points[i]["speed"] + (100.0 if points[i]["model"] == "dry" else 0.0)
        for i in range(len(points))
    }
    queue = Queue(points, list(range(len(points))))
    first = [queue.take() for _ in range(FIRST)]
    assert {points[i]["model"] for i in first} == {"dry", "lubricated"}
    assert max(points[i]["speed"] for i in first) - min(points[i]["speed"] for i in first) > 8.0
    for index in first:
        queue.learn(index, cost[index])
    order = [queue.take() for _ in range(len(queue))]
    dry = [points[i]["model"] == "dry" for i in order]
    assert dry == sorted(dry, reverse=True)  # dearer by far
    guessed = [points[i]["speed"] for i, d in zip(order, dry, strict=True) if d]
    assert sum(guessed[:4]) > sum(guessed[-4:])
