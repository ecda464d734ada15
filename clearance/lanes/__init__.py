"""Many runs of one structure side by side in vector registers: a lane each, with its own time and
step.
"""

from clearance.values.checks import lazily

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
