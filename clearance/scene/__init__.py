"""Scenes: from elements, from cases, from names of laws, from TOML; as plain data and back."""

from clearance.values.lazy import lazily

__getattr__ = lazily(__name__, {"Scene": "scene"})
