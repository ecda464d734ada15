"""Processors of this process, and functions that run on several of them at a time."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor


def processors() -> int:
    """Processors that this process may use: of a job on a cluster those it was given."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def at_once(function: Callable, items: Iterable, threads: int) -> Iterator[tuple]:
    """Each item with its function, in their order; some of them at a time, in threads."""
    if threads == 1:
        yield from ((item, function(item)) for item in items)
        return
    pool, waiting = ThreadPoolExecutor(threads), deque()
    try:
        for item in items:
            waiting.append((item, pool.submit(function, item)))
            if len(waiting) > threads:
                item, answer = waiting.popleft()
                yield item, answer.result()
        for item, answer in waiting:
            yield item, answer.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
