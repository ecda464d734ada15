from clearance.film.elastic import elastic_film as elastic
from clearance.film.online import conserving_film as conserving
from clearance.film.online import fast_film as fast
from clearance.film.online import fem_film as fem
from clearance.film.tabulated import table_film as table
from clearance.laws import full_sommerfeld as sommerfeld
from clearance.laws import harmonic as harmonic
from clearance.laws import long_film as long
from clearance.laws import pinkus_sternlicht as pinkus_sternlicht
from clearance.laws import short_film as short

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
