"""The share of a study that is done: a bar where it is seen, else lines of the logger."""

import importlib.util
import logging
import sys
import time
from collections.abc import Callable
from functools import cached_property, wraps
from typing import TypeVar

Study = TypeVar("Study", bound=Callable)
LOG = logging.getLogger("clearance")
DELAY = 1.0  # seconds before a bar is shown
INTERVAL = 30.0  # seconds between lines of the logger
FORM = "{l_bar}{bar}| {elapsed} passed, {remaining} left{postfix}"
WORDS = "{desc}: {elapsed} passed{postfix}"  # of a study without a share

#: what the process does: "command" shows no bar unless one is requested, "study" is inside another
_state: dict[str, bool] = {"command": False, "study": False}


def by_command() -> None:
    """Show bars only where they are requested: commands have lines of their own."""
    _state["command"] = True


def is_worker() -> bool:
    processes = sys.modules.get("multiprocessing")
    return processes is not None and processes.parent_process() is not None


def seen() -> bool:
    """True where a person may look: in a notebook, or at a terminal."""
    return "ipykernel" in sys.modules or sys.stderr is not None and sys.stderr.isatty()


class ProgressBar:
    """A bar of the share that is done, or of words, once a study takes longer than a second.

    Where nobody sees it, a line each half minute. printer: a function that shows lines, default the
    logger. It shows news of sweeps, too, which log their own. silent: nothing is shown. before:
    points of a sweep that were done before.
    """

    before = 0

    def __init__(
        self, name: str, printer: Callable[[str], None] | None = None, silent: bool = False
    ):
        self.name, self.printer, self.silent = name, printer, silent
        self.bar = None
        self.began = self.last = time.perf_counter()

    @cached_property
    def seen(self) -> bool:
        """True where a person may look."""
        return seen()

    def __call__(self, state, words: str = "", always: bool = False) -> None:
        """state: done share, a sentence, or numbers of points as `sweep` reports them; always: show
        it although no line is due.
        """
        self.before = getattr(state, "before", 0)
        for line in getattr(state, "news", ()) if self.printer and not self.silent else ():
            self.clear()
            self.printer(line)
        now = time.perf_counter()
        due = always or now - self.last >= (DELAY if self.seen else INTERVAL)
        if self.silent or not due:
            return
        if isinstance(state, str):
            state, words = None, state
        elif hasattr(state, "total"):
            words = f"{state.done} of {state.total} done, {state.failed} failed"
            words += f", {state.running} running, {state.rate:.3g} runs/s"
            state = (state.done + state.failed) / state.total
        if not self.seen:
            self.last = now
            share = "" if state is None else f"{state:.0%} done "
            line = f"{self.name}: {now - self.began:.0f} s, {share}{words}"
            (self.printer or LOG.info)(line.rstrip())
            return
        form = WORDS if state is None else FORM
        bar = self.bar = self.bar or self._new(form)
        bar.bar_format = form
        bar.set_postfix_str(words, refresh=state is None)
        if state is not None:
            bar.update(100.0 * state - bar.n)

    def _new(self, form: str):
        if "ipykernel" in sys.modules and importlib.util.find_spec("ipywidgets"):
            from tqdm.auto import tqdm
        else:
            from tqdm import tqdm
        bar = tqdm(total=100, unit="%", desc=self.name, bar_format=form, leave=False)
        bar.start_t -= time.perf_counter() - self.began
        return bar

    def clear(self) -> None:
        """Make room for other lines; the next call draws the bar again."""
        if self.bar is not None:
            self.bar.clear()

    def close(self) -> None:
        """Take the bar away, for good."""
        self.silent = True
        if self.bar is not None:
            self.bar.close()

    def __enter__(self) -> "ProgressBar":
        return self

    def __exit__(self, *_) -> None:
        self.close()


def watched(study: Study) -> Study:
    """Decorate a function with an argument `progress`: a bar stands for None, for True also in
    commands. False, studies inside a study and workers have none.
    """

    @wraps(study)
    def shown(*arguments, progress=None, **options):
        wanted = progress is True or progress is None and not _state["command"]
        inner = _state["study"] or is_worker()
        bar = ProgressBar(study.__name__) if wanted and not inner else None
        before, _state["study"] = _state["study"], True
        try:
            report = bar if progress is None or isinstance(progress, bool) else progress
            return study(*arguments, progress=report, **options)
        finally:
            _state["study"] = before
            if bar is not None:
                bar.close()

    return shown  # type: ignore[return-value]
