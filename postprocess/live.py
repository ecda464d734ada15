"""A page that computes: the page of `view`, whose mechanism is integrated in the browser as its
reader moves sliders.
"""

import base64
from pathlib import Path

from clearance.postprocess.moving import OFFSETS, Moving, of_all
from clearance.postprocess.view import _checked, _write, document

from clearance.results.record import Record


def live(record: Record, path: str | Path, sliders: dict, module: bytes) -> Path:
    """Write the page of a run; returns its path. Raises ValueError for a name that does not end in
    .html.

    sliders: facts of `exporting.page`; module: WebAssembly of the scene.
    """
    path = _checked(path)
    title = record.attributes["case"]
    moving = Moving(record, title)
    facts = {
        "title": title,
        "first": moving.telling(),
        "open": [0],
        "map": None,
        "live": sliders | {"offsets": OFFSETS},
    }
    wasm = base64.b64encode(module).decode()
    return _write(path, document(facts | of_all([moving]), [moving.pack.text()], wasm))
