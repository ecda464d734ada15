"""The version of the package, which pyproject.toml reads here."""

VERSION = "0.3.0.dev0"
