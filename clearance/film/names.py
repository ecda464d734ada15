"""Film models by their names on the command line, from coarse to fine: `films.short()`,
`films.table()`.
"""

from clearance.film.elastic import elastic_film as elastic
from clearance.film.online import conserving_film as conserving
from clearance.film.online import fast_film as fast
from clearance.film.online import fem_film as fem
from clearance.film.tabulated import table_film as table
from clearance.laws import full_sommerfeld as sommerfeld
from clearance.laws import harmonic, pinkus_sternlicht
from clearance.laws import long_film as long
from clearance.laws import short_film as short
from clearance.values.checks import absent

__all__ = [
    "conserving",
    "elastic",
    "fast",
    "fem",
    "harmonic",
    "long",
    "pinkus_sternlicht",
    "short",
    "sommerfeld",
    "table",
]

__getattr__ = absent(__name__, __all__)
