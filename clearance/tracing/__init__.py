"""Expressions, laws and loops as one trace; its LLVM IR and its Python text; no mechanics."""
