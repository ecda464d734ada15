"""Tests, with published numbers (`validation/`), complete runs (`regression/`), other ways to an
answer (`oracles/`) and costs (`benchmarks/`).

One thread of linear algebra for each worker: more would wait for each other.
"""

import os

# numpy reads it when it is imported, so it stands before the imports of all tests
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
