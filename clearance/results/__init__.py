"""Records of runs, in memory and in files: written, read, checked."""

from clearance.values.lazy import lazily

__getattr__ = lazily(
    __name__,
    {"PressureFields": "record", "Record": "record", "Result": "result", "open_result": "result"},
)
