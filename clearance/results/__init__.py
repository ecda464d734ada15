"""Records of runs, in memory and in files: written, read, checked."""

from clearance.values.checks import lazily

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
