"""Elements: what a mechanism is made of, one kind a file."""

from clearance.values.checks import lazily

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
