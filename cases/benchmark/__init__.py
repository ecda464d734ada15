"""Problems of the benchmark set as scenes; docs/benchmark states each without this code."""
