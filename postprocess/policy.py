"""The content-security policy of pages: a browser runs and styles only what this package wrote."""

import base64
import hashlib


def policy(script: str, style: str, **more: str) -> str:
    """For the texts of the only script and the only style; more: sources by directive."""
    sources = {"default-src": "'none'", "script-src": _digest(script), "style-src": _digest(style)}
    sources |= {"base-uri": "'none'", "form-action": "'none'"}
    sources |= {name.replace("_", "-"): source for name, source in more.items()}
    return "; ".join(f"{name} {source}" for name, source in sources.items())


def _digest(text: str) -> str:
    """A source of the policy: the element with exactly this text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
