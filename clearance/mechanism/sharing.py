"""Unknowns that their equations determine: a bipartite matching of equations and bodies.

Every equation (two of a joint, one of a drive) is given to one of the bodies that it constrains. A
body takes three at most, as it has three coordinates. Where all equations find a place, a set of
bodies is determined if each of them holds three that constrain no body outside the set. The
smallest such set around a body can be reached from it along the equations that bodies hold,
whatever the matching (Dulmage and Mendelsohn, Canadian J. Math. 10 (1958) 517).
"""

from collections.abc import Hashable, Iterable

COORDINATES = 3  # of a body in the plane


class Sharing:
    """Bodies and the equations given to them.

    equations: the bodies that each one constrains, one or two; bodies: all, in the order that
        decides between sets of one size. visits counts the bodies looked at.
    """

    def __init__(self, bodies: Iterable[Hashable], equations: Iterable[tuple[Hashable, ...]]):
        self.order = {body: i for i, body in enumerate(bodies)}
        self.held: dict[Hashable, list[int]] = {body: [] for body in self.order}
        self.ends = list(equations)
        self.visits = 0
        for equation in sorted(range(len(self.ends)), key=lambda e: len(self._left(e))):
            self._give(equation)

    def place(self, bodies: Iterable[Hashable]) -> None:
        """These bodies have their place now; equations that they share with others pass to
        those.
        """
        freed = [e for body in bodies for e in self.held.pop(body)]
        for equation in freed:
            self._give(equation)

    def _left(self, equation: int) -> list[Hashable]:
        return [body for body in self.ends[equation] if body in self.held]

    def _give(self, equation: int) -> None:
        """Give an equation to a body with room, others moving on where they have to.

        One that repeats others finds no body and is left out.
        """
        # what would come, where from
        moving = dict.fromkeys(self._left(equation), (equation, None))
        waiting = list(moving)
        for body in waiting:
            self.visits += 1
            if len(self.held[body]) < COORDINATES:
                self._move(body, moving)
                return
            for candidate in self.held[body]:
                new = [b for b in self._left(candidate) if b not in moving]
                moving |= dict.fromkeys(new, (candidate, body))
                waiting += new

    def _move(self, body: Hashable, moving: dict) -> None:
        while body is not None:
            equation, origin = moving[body]
            self.held[body].append(equation)
            if origin is not None:
                self.held[origin].remove(equation)
            body = origin

    def smallest(self) -> frozenset | None:
        """The smallest determined set of bodies, the first of these in their order; None for
        none.
        """
        best = None
        for body in self.held:
            reached = self._around(body, len(self.held) if best is None else len(best[1]))
            if reached is not None:
                places = len(reached), sorted(self.order[b] for b in reached)
                best = (
                    min(best, (places, reached), key=lambda b: b[0]) if best else (places, reached)
                )
        return frozenset(best[1]) if best else None

    def _around(self, body: Hashable, most: int) -> set | None:
        """The smallest determined set with this body; None for none of so many bodies at most."""
        reached, waiting = {body}, [body]
        for member in waiting:
            self.visits += 1
            if len(self.held[member]) < COORDINATES or len(reached) > most:
                return None
            new = {b for e in self.held[member] for b in self._left(e)} - reached
            reached |= new
            waiting += new
        return reached


__all__ = ["Sharing"]
