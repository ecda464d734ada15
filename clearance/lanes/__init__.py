"""Many runs of one structure side by side in vector registers: a lane each, with its own time and
step.
"""

from clearance.values.lazy import lazily

__getattr__ = lazily(__name__, dict.fromkeys(("Answers", "Group", "Points", "impossible"), "group"))
