"""Machine code: compiled from LLVM IR, called by its address, stored on disk."""
