"""Film models by their names on the command line, from coarse to fine: `films.short()`,
`films.table()`.
"""

from clearance.values.checks import lazily

__getattr__, __dir__, __all__ = lazily(__name__, __file__)
