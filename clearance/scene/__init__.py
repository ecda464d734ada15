"""Scenes: from elements, from cases, from names of laws, from TOML; as plain data and back."""

from clearance.values.checks import lazily

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
