"""Layers of a bimorph one by one: text such as ``"brass 0.2 mm; PZT-5A 0.26 mm +x"``.

From the lower face (−x) to the upper one (+x).  A ceramic says how it is poled, and may say which
of its faces has the drive voltage (``hot +x``; by default the outer one), that both have none
(``shorted``) or that it has no electrodes (``bare``).  Poled along the bimorph it has
interdigitated electrodes (``+z pitch 0.5 mm``; ``-z`` where a positive voltage is against the
poling).  A layer of another width than the bimorph's states it after the thickness (``wide 5
mm``), and one that covers part of the length where it is (``from 5 mm to 12 mm``).  Read at the
edge with units, held in metres.  Each size is a scene key besides, such as
``bimorph.layers.2.end``, by which it is varied.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import takewhile
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, ValidationInfo
from pydantic.fields import FieldInfo

from tactgen.geometry.device.ceramic_library import LIBRARY, library_name
from tactgen.geometry.device.materials import Own, Spread
from tactgen.geometry.device.parameter_group import NONE, read_list
from tactgen.geometry.device.shim_library import PAPERS, SHIMS, shim_name
from tactgen.geometry.errors import InputError
from tactgen.geometry.synonyms import nearest
from tactgen.geometry.units import NUMBER, Unit, quantity, quoted

_EXAMPLE = "brass 0.2 mm; PZT-5A 0.26 mm +x"
_REMEDY = f'write for example "{_EXAMPLE}"'
_THICKNESS = Unit("m", "thickness", "0.2 mm", above=0.0, limits=(1e-9, 0.1), shown="mm")
_WIDTH = Unit("m", "width", "5 mm", above=0.0, limits=(1e-6, 1.0), shown="mm")
_PLACE = Unit("m", "length", "5 mm", at_least=0.0, limits=(0.0, 1.0), shown="mm")
_END = replace(_PLACE, at_least=None, above=0.0)
_PITCH = Unit("m", "pitch", "0.5 mm", above=0.0, limits=(1e-6, 0.1), shown="mm")
#: Sizes of a layer by the last part of their scene keys.
SIZES = {
    "thickness": _THICKNESS, "width": _WIDTH, "pitch": _PITCH, "start": _PLACE, "end": _END,
}  # fmt: skip
#: Declaration of each size, as of any other number of a scene.
_DECLARATIONS = {name: FieldInfo.from_annotation(quantity(unit)) for name, unit in SIZES.items()}
#: How far the sizes of somebody else's layers may lie from what is said of them.
SCATTER = {"thickness": Own("layer thickness", 0.05), "width": Own("width", 0.025)}
#: Such a key, less its group; of several layers it changes the size that they share.
_SIZE_NAME = re.compile(rf"layers\.[1-9]\d?(\+[1-9]\d?)*\.({'|'.join(SIZES)})", re.ASCII)
#: A number with its unit.
_SIZE = rf"{NUMBER}\s*(?!from\b|to\b|wide\b)[a-zµμ][^\s\d+-]*"
_LAYER = re.compile(
    rf"(?P<material>\S.*?)\s+(?P<thickness>{_SIZE})"
    rf"(?:\s+wide\s+(?P<width>{_SIZE}))?"
    rf"(?:\s+from\s+(?P<start>{_SIZE}))?"
    rf"(?:\s+to\s+(?P<end>{_SIZE}))?"
    rf"(?:\s+(?P<poling>[+-]x|[+-]z\s+pitch\s+(?P<pitch>{_SIZE})))?"
    r"(?:\s+(?P<electrodes>hot [+-]x|shorted|bare))?",
    re.IGNORECASE | re.ASCII,
)
#: What is in no material's name: a size that stands in the wrong place, a tolerance.
_MISPLACED = re.compile(r"\d\s*[µu]?m?m\b|\d\.\d|±")
#: Largest number of layers.
_MOST = 50
#: Materials of the scene's own, by the group that states them.
OWN = ("piezo", "shim", "glue")


class Layer(NamedTuple):
    """One layer."""

    #: ``piezo``, ``shim`` or ``glue`` as the scene states them, or a library's name
    material: str
    thickness: float  #: m
    poling: int = 0  #: Direction along x (along z with a pitch), 0 of what is not piezoelectric
    electrodes: Literal["", "hot", "shorted", "bare"] = ""
    hot: int = 0  #: Face (along x) at the drive voltage, 0 for the outer one
    width: float = 0.0  #: m, in the middle of the bimorph's; 0 for the bimorph's own
    #: m, centre distance of neighbouring fingers of interdigitated electrodes; 0 for a ceramic
    #: poled through its thickness
    pitch: float = 0.0
    start: float = 0.0  #: m, where it begins above the lower end of `bimorph.length`
    end: float = 0.0  #: m, where it ends, on the same scale; 0 for the upper end
    of: Any = None  #: Constants, as the section has them, in place of those of its name

    @property
    def is_ceramic(self) -> bool:
        """Whether it is piezoelectric."""
        return self.poling != 0

    @property
    def is_patch(self) -> bool:
        """Whether it states its place along the length: then it goes on into no tab."""
        return self.start > 0.0 or self.end > 0.0

    @property
    def electrode_distance(self) -> float:
        """Distance (m) that a voltage lies across: of its faces, or of interdigitated fingers."""
        return self.pitch or self.thickness

    def __str__(self) -> str:
        return self.written({})

    def written(self, tolerances: Mapping[str, str]) -> str:
        """Layer as a scene states it, with what stands behind some of its sizes."""

        def size(word: str, name: str) -> list[str]:
            value = getattr(self, name)
            known = [word, SIZES[name].show(value), tolerances.get(name, "")]
            return [" ".join(filter(None, known))] if value else []

        words = [self.material, *size("", "thickness"), *size("wide", "width")]
        words += size("from", "start") + size("to", "end")
        words += [_direction(self.poling, "z" if self.pitch else "x")] if self.poling else []
        words += size("pitch", "pitch")
        words += [self.electrodes] if self.electrodes else []
        words += [_direction(self.hot)] if self.hot else []
        return " ".join(words)


def is_size(name: str) -> bool:
    """Whether a name in the group ``bimorph`` is that of a listed layer's size."""
    return _SIZE_NAME.fullmatch(name) is not None


def single_sizes(name: str) -> tuple[str, ...]:
    """Names of the sizes of single layers that one of several means; none if it is no size."""
    if not is_size(name):
        return ()
    group, numbers, size = name.split(".")
    return tuple(f"{group}.{number}.{size}" for number in numbers.split("+"))


def declaration(name: str) -> FieldInfo:
    """Declaration of a layer's size by its name."""
    return _DECLARATIONS[name.rpartition(".")[2]]


class Laminate(tuple[Layer, ...]):
    """Layers from the lower face to the upper one; empty for piezo / shim / piezo."""

    __slots__ = ()

    def __str__(self) -> str:
        return self.written({})

    def written(self, tolerances: Mapping[str, str]) -> str:
        """Layers as a scene states them, with what stands behind sizes of these names."""
        of = [
            {size: tolerances.get(f"layers.{number}.{size}", "") for size in SIZES}
            for number in range(1, len(self) + 1)
        ]
        return "; ".join(map(Layer.written, self, of)) or NONE

    @property
    def thickness(self) -> float:
        """Sum of the thicknesses (m)."""
        return sum(layer.thickness for layer in self)

    @property
    def continues(self) -> tuple[bool, ...]:
        """Whether each layer goes on where the ceramic ends: not ceramics, glue and patches."""
        return tuple(
            not (layer.is_ceramic or layer.material == "glue" or layer.is_patch) for layer in self
        )

    def extents(self, length: float) -> list[tuple[float, float]]:
        """Where each layer begins and ends (m) on a bimorph's length (m)."""
        return [(layer.start, layer.end or length) for layer in self]

    @property
    def sizes(self) -> dict[str, Any]:
        """All sizes that are stated, by their names, such as ``layers.2.end``.

        Layers that begin or end together do so under one name, ``layers.1+3.end``: where only
        one of them moves, a piece appears between the two, and answers have a kink.
        """
        return {
            f"layers.{'+'.join(map(str, self._together(number, size)))}.{size}": value
            for number, layer in enumerate(self, start=1)
            for size in SIZES
            if (value := getattr(layer, size))
        }

    def _together(self, number: int, size: str) -> list[int]:
        """Numbers, from 1, of the layers that begin or end where one does."""
        if size not in ("start", "end"):
            return [number]
        value = getattr(self[number - 1], size)
        return [n for n, other in enumerate(self, start=1) if getattr(other, size) == value]

    @property
    def smooth_sizes(self) -> tuple[str, ...]:
        """Names of those by which sections and pieces follow a formula, and no solved field."""
        return tuple(
            name
            for name in self.sizes
            if not (self[self._places(name)[0][0]].pitch and name.endswith(("thickness", "pitch")))
        )

    def spreads(self) -> dict[str, Spread]:
        """Assumed range of each size that has one, by its name; of glue nothing is known."""
        kinds = ((name, value, name.rpartition(".")[2]) for name, value in self.sizes.items())
        return {
            name: SCATTER[kind].around(value)
            for name, value, kind in kinds
            if kind in SCATTER and self[self._places(name)[0][0]].material != "glue"
        }

    def size(self, name: str) -> Any:
        """Size by its name, 0 where it is not stated.

        Raises InputError if there is no such layer, or several are named that differ.
        """
        numbers, size = self._places(name)
        first, *others = (getattr(self[number], size) for number in numbers)
        for number, other in zip(numbers[1:], others, strict=True):
            if np.any(other != first):
                shown = SIZES[size].show
                raise InputError(
                    f"bimorph.{name} is one size of several layers, and layer {numbers[0] + 1} "
                    f"has {shown(first)}, layer {number + 1} {shown(other)}; state them alike in "
                    "bimorph.layers, or name one layer"
                )
        return first

    def with_sizes(self, values: Mapping[str, Any]) -> Laminate:
        """Layers with other sizes by name, unchecked; InputError if there is no such layer."""
        layers = list(self)
        for name, value in values.items():
            numbers, size = self._places(name)
            for number in numbers:
                layers[number] = layers[number]._replace(**{size: value})
        return Laminate(layers)

    def _places(self, name: str) -> tuple[list[int], str]:
        """Numbers of the layers, from 0, and which of their sizes a name means."""
        _, named, size = name.split(".")
        numbers = [int(number) for number in named.split("+")]
        if not self:
            raise InputError(
                f"bimorph.{name} is a size of a listed layer, and none is listed; set "
                "bimorph.layers, or piezo_thickness or shim_thickness of bimorph"
            )
        if max(numbers) > len(self):
            raise InputError(
                f"bimorph.{name} is a size of layer {max(numbers)}, and bimorph.layers lists "
                f"{len(self)}; use bimorph.layers.1.{size} to bimorph.layers.{len(self)}.{size}"
            )
        if len(set(numbers)) < len(numbers):
            raise InputError(f"bimorph.{name} names a layer twice; name each once")
        return [number - 1 for number in numbers], size

    def with_hot_faces(self) -> Laminate:
        """The same layers, each ceramic of which states its face at the drive voltage."""
        faces = [0 if layer.pitch else self.hot(number) for number, layer in enumerate(self)]
        stated = (
            layer._replace(electrodes="hot", hot=face) if face else layer
            for layer, face in zip(self, faces, strict=True)
        )
        return Laminate(stated)

    def region(self, number: int) -> str:
        """Name of a layer's part of the body: what it is, and its number from 1 at −x."""
        layer = self[number]
        kind = "piezo" if layer.is_ceramic else "glue" if layer.material == "glue" else "shim"
        return f"{kind}_{number + 1}"

    def hot(self, number: int) -> int:
        """Face (along x) of a layer at the drive voltage, 0 if none is.

        Interdigitated electrodes count as two faces.
        """
        layer = self[number]
        if not layer.is_ceramic or layer.electrodes in ("shorted", "bare"):
            return 0
        if layer.pitch:
            return 1
        low = sum(other.thickness for other in self[:number])
        return layer.hot or (1 if low + 0.5 * layer.thickness >= 0.5 * self.thickness else -1)

    def faces(self, number: int) -> tuple[int, ...]:
        """Faces (along x) of a ceramic that are equipotential: both with electrodes, else none.

        Of bare ceramics that touch none with electrodes the lowest face, so that their potential
        has a level; no charge flows through them all the same.
        """
        if self[number].electrodes != "bare":
            return (-1, 1)
        above = takewhile(lambda layer: layer.is_ceramic, self[number + 1 :])
        lowest = number == 0 or not self[number - 1].is_ceramic
        return (-1,) if lowest and all(layer.electrodes == "bare" for layer in above) else ()


PLAIN = Laminate()


def _direction(sign: int, axis: str = "x") -> str:
    return f"{'+' if sign > 0 else '-'}{axis}"


def read_layers(value: Any, info: ValidationInfo) -> Laminate:
    """Layers from their text, a list of texts, or layers.

    Raises ValueError with a sentence that names the remedy.
    """
    if isinstance(value, str) and not value.strip():
        raise ValueError(f"is empty; {_REMEDY}, or {NONE} for piezo, shim and piezo")
    found: Laminate = read_list(value, Laminate, Layer, lambda text: _layer(text, info), _REMEDY)
    if len(found) > _MOST:
        raise ValueError(f"has {len(found)} layers; give at most {_MOST}")
    return found


def read_sizes(layers: Laminate, values: Mapping[str, Any], info: ValidationInfo) -> Laminate:
    """Layers with some sizes in place of those of their text, by name as a scene states them.

    Raises InputError in a sentence that names the key.
    """
    read = {}
    for name, value in values.items():
        size = name.rpartition(".")[2]
        try:
            read[name] = SIZES[size](value, info)
        except ValueError as error:
            raise InputError(f"bimorph.{name} = {quoted(value)} {error}") from None
        if size == "pitch" and not layers.size(name):
            raise InputError(
                f"bimorph.{name} = {SIZES[size].show(read[name])} is of a layer without "
                "interdigitated electrodes; state their pitch in bimorph.layers"
            )
    return layers.with_sizes(read)


def _layer(text: str, info: ValidationInfo) -> Layer:
    found = _LAYER.match(text)
    if found is None or _MISPLACED.search(found["material"]):
        raise ValueError(
            f"has the layer {quoted(text)}, which does not begin with a material and a thickness "
            f"with its unit; {_REMEDY}"
        )
    if rest := text[found.end() :].strip():
        raise ValueError(
            f"has the layer {quoted(text)}, where {quoted(rest)} is not understood; after material "
            'and thickness may stand, in this order, "wide 3 mm", "from 5 mm", "to 12 mm", the '
            'poling of a ceramic ("+x", "+z pitch 0.5 mm") and its electrodes ("hot -x", '
            '"shorted", "bare")'
        )
    sizes = []
    for name, of in SIZES.items():
        try:
            sizes.append(of(found[name], info) if found[name] else 0.0)
        except ValueError as error:
            raise ValueError(f"has the layer {quoted(text)}, whose {name} {error}") from None
    thickness, width, pitch, start, end = sizes
    material, ceramic = _material(found["material"])
    poling, electrodes = found["poling"], (found["electrodes"] or "").lower()
    if ceramic and poling is None:
        raise ValueError(
            f"has the layer {quoted(text)} without a poling; add +x or -x, as in "
            f'"{material} {_THICKNESS.show(thickness)} +x"'
        )
    if not ceramic and (poling or electrodes):
        raise ValueError(
            f"has poling or electrodes in the layer {quoted(text)}, and {material} is not "
            "piezoelectric; leave them out"
        )
    if pitch and electrodes not in ("", "shorted"):
        raise ValueError(
            f"has the layer {quoted(text)}, whose interdigitated electrodes cannot be "
            f'"{electrodes}"; leave that out, or write shorted'
        )
    kind, _, face = electrodes.partition(" ")
    sign = {"+": 1, "-": -1, "": 0}
    poled, hot = sign[(poling or "")[:1]], sign[face[:1]]
    return Layer(material, thickness, poled, kind, hot, width, pitch, start, end)  # type: ignore[arg-type]


def _material(text: str) -> tuple[str, bool]:
    """Name of a material, and whether it is piezoelectric."""
    if text.lower() in OWN:
        return text.lower(), text.lower() == "piezo"
    if name := library_name(text):
        return name, True
    if name := shim_name(text):
        return name, False
    known = (*OWN, *LIBRARY, PAPERS, *SHIMS)
    raise ValueError(
        f"has the material {quoted(text)}, which is not in the library{nearest(text, known)}; use "
        f"one of {', '.join(known)}"
    )


Layers = Annotated[Any, BeforeValidator(read_layers)]
