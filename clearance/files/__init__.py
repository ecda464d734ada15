"""Any file: locked, sealed by a digest, read with care."""
