"""A case: a scene that depends on parameters, from a Python file or a scene file."""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from clearance.scene.joint_options import resolved
from clearance.scene.scene import Scene
from clearance.values import checks
from clearance.values.units import quantity

if TYPE_CHECKING:  # what few parameters are
    from clearance.values.fit_class import FitClass

THIN = 1e-6  # clearance [m] at which journals have the diameter of their bearings
_SWITCH = {
    "true": True,
    "yes": True,
    "on": True,
    "1": True,
    "false": False,
    "no": False,
    "off": False,
    "0": False,
}


@dataclass(frozen=True)
class Parameter:
    """One swept quantity of a case: name, type, default, unit and what it is."""

    name: str
    kind: type
    default: object
    units: str
    text: str

    def value(self, text: str) -> object:
        """A value from the command line, such as 300rpm, 0.1mm or dry; or the default's word, such
        as auto.
        """
        if isinstance(self.default, str) and text.strip() == self.default:
            return self.default
        try:
            if self.kind is bool:
                return _SWITCH[text.strip().lower()]
            return text if self.kind is str else self._number(quantity(text, self.units))
        except KeyError:
            raise ValueError(f"{self.name}: {text!r} is neither true nor false") from None
        except ValueError as error:
            raise ValueError(f"{self.name}: {error}") from None

    def _number(self, number: float) -> float | int:
        if self.kind is int and number != int(number):
            raise ValueError(f"{number:g} is not a whole number")
        return self.kind(number)


@dataclass(frozen=True)
class Case:
    """A case: its parameters, and the function that makes its scene of their values.

    path: of its file, None where it has none. length: of a run of which none is requested and
    nothing turns [s], where the file has one. reference: text of which `find_case` makes it in
    any process; empty for a function that only this process has.
    """

    name: str
    path: Path | None
    function: Callable[..., Scene]
    summary: str
    parameters: Mapping[str, Parameter]
    length: float | None = None
    library: bool = False
    reference: str = ""

    @property
    def files(self) -> list[Path]:
        """Files of its code."""
        return [] if self.path is None else [self.path]

    @property
    def source(self) -> str:
        """Digest of its file's text, else of its reference."""
        text = self.path.read_bytes() if self.path else self.reference.encode()
        return hashlib.sha256(text).hexdigest()[:16]

    @property
    def until(self) -> float:
        """Length of a run of which none is requested and nothing turns [s]: 2 s where the file has
        none.
        """
        field = "until" if self.path and self.path.suffix == ".toml" else "UNTIL"
        length = 2.0 if self.length is None else self.length
        return checks.positive(f"case {self.name}: {field}", length)

    def read(
        self, texts: Mapping[str, str], beside: Mapping[str, object] | None = None
    ) -> dict[str, object]:
        """Values from the command line; of fits, such as clearance=H7/f7, the mean clearance.

        beside: further values of parameters. Raises ValueError.
        """
        fits = [n for n, t in texts.items() if self.takes_fit(n, t)]
        values = {n: self.parameters[n].value(t) for n, t in texts.items() if n not in fits}
        beside = {n: v for n, v in (beside or {}).items() if n not in texts} | values
        read = values | {n: self.fit(n, texts[n], beside).value for n in fits}
        return {name: read[name] for name in texts}

    def takes_fit(self, name: str, text: object) -> bool:
        """True for the class of a fit and a parameter that is a length."""
        about = self.parameters.get(name)
        if about is None or (about.kind, about.units) != (float, "m") or not isinstance(text, str):
            return False
        from clearance.values.fit_class import is_fit_class

        return is_fit_class(text)

    def fit(self, name: str, text: str, beside: Mapping[str, object]) -> "FitClass":
        """The fit of a clearance at the diameter of its joints, where the text has none.

        beside: values of other parameters. Raises ValueError where joints have several diameters.
        """
        from clearance.values.fit_class import fit_class, has_diameter

        if has_diameter(text):
            return fit_class(text)
        # dry: a film would have its table made for a clearance that no run has
        dry = {"model": "dry"} if "model" in self.parameters else {}
        joints = self.scene(**{**beside, **dry, name: THIN}).clearance_joints
        mine = [j for j in joints if name in ("clearance", f"{j.key}/clearance")]
        # journals of cases get thinner with the clearance, bearings of others wider
        sizes = {round(2.0 * j.radius, 5) for j in mine if hasattr(j, "radius")}
        if len(sizes) != 1:
            raise ValueError(f"{name}: {text} needs a diameter, as {text}@20mm")
        return fit_class(text, sizes.pop())

    def scene(self, **values) -> Scene:
        """The scene for given parameter values; an unknown name lists the known ones."""
        parameters = self.parameters
        for name in values:
            checks.known(f"case {self.name} has no parameter", name, parameters)
        texts = {
            n: v
            for n, v in values.items()
            if isinstance(v, str) and parameters[n].kind in (float, int)
        }
        values |= self.read(texts, values)
        scene = self.function(**values)
        if not isinstance(scene, Scene):
            raise TypeError(
                f"case {self.name}: scene() must return a Scene, got {type(scene).__name__}"
            )
        vars(scene)["case"] = self
        scene.parameters.update(values)
        defaults = {n: p.default for n, p in parameters.items() if n not in values}
        if self.path is not None:
            scene.origin["case_file"] = self.name if self.library else str(self.path)
        scene.origin["defaults"] = json.dumps(defaults, default=str, sort_keys=True)
        automatic = resolved(defaults | values, scene.joints)
        scene.origin["resolved"] = json.dumps(automatic, sort_keys=True)
        return scene
