"""Names of parts, on which no trace depends: marks of positions stand for them there."""

import re
from collections.abc import Sequence
from dataclasses import replace

from clearance.scene.scene import Scene

_MARK = re.compile("⟦([0-9]+)⟧")


def marked(scene: Scene) -> Scene:
    """The scene with a mark of its position as the name of each part."""

    def renamed(part):
        return replace(part, name=f"⟦{scene.positions[part.key]}⟧")

    return scene.rebuilt(body=renamed, element=renamed)


def named(text: str, names: Sequence[str]) -> str:
    """A text with the names of parts, by their positions, in place of their marks."""
    return _MARK.sub(lambda mark: names[int(mark[1])], text)
