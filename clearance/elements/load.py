"""Base of drives, springs, forces and torques: elements that join nothing."""

from clearance.elements.element import Element
from clearance.values import checks


class Load(Element):
    """An element that joins nothing; its name is by default that of its kind."""

    kind = "load"

    def __post_init__(self):
        name = self.name if self.name is not None else self.kind
        self._set("name", checks.identifier(f"{type(self).__name__} name", name))
        self._check_fields()
