"""Effect of the ceramic's assumed constants: the full tensor, one choice at a time.

The paper gives three constants of its ceramic, a solid needs ten.  Each row changes one of the
assumed ones within the scatter of soft PZT and keeps the reduced constants of the one-dimensional
models, unless it says otherwise.  Sets that no material can have are refused with the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from tactgen.geometry.device.material_library import LIBRARY
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.errors import InputError
from tactgen.validation.models.difference import SolidCase, Values, beam_values, solid_values
from tactgen.validation.scene.scene import Scene

#: Permittivity with which the paper's d31 and s11 give a coupling beyond known ceramics.
_LOW_EPS33 = 3400.0


@dataclass(frozen=True)
class MaterialRow:
    """One choice: the values of solid and beam, or why it is impossible."""

    name: str
    what: str
    values: Values | None = None
    beam: Values | None = None
    refused: str = ""


#: Soft ceramics that differ most in what the reduced constants do not fix.
_REST = ("PZT-5H", "PZT-5A")


def choices(ceramic: Piezoceramic) -> Iterator[tuple[str, str, Piezoceramic]]:
    """Yield (name, why it could be so, full material), the assumed one first."""
    yield "as it stands", ceramic.origin, ceramic
    reduced = ceramic.reduced()
    # M1876 is PZT-5H by ratio already
    same = {ceramic.name, "M1876", *(("PZT-5H",) if ceramic.name == "M1876" else ())}
    for name in _REST:
        other = LIBRARY[name]
        if name not in same:
            yield (
                f"rest by ratio to {name}",
                "all that the reduced constants do not fix",
                other.with_values(**reduced),
            )
    for factor in (0.9, 1.1):
        yield f"d33 x {factor:g}", "k33 of soft PZT: 0.68 to 0.78", _with_d(ceramic, factor, 1.0)
    yield "d15 = 0", "no shear piezoelectricity: an extreme", _with_d(ceramic, 1.0, 0.0)
    for ratio in (0.25, 0.40):
        yield (
            f"-s12/s11 = {ratio:g}",
            "in the plane, where d31 = d32 acts; isotropic-like ceramics to PZT-4",
            _with_s12(ceramic, ratio),
        )
    for factor in (0.9, 1.1):
        yield f"s13 x {factor:g}", "thickness against length", _scaled(ceramic, (0, 2), factor)
    yield "s33 x 1.1", "compliance through the thickness", _scaled(ceramic, (2, 2), 1.1)
    spread = ceramic.spreads.get("eps33")
    for eps33 in (_LOW_EPS33, spread.low, spread.high) if spread else ():
        yield (
            f"eps33 = {eps33:g}",
            "permittivity, eps11 and d33 by ratio: here the reduced set itself changes",
            ceramic.with_values(**{**reduced, "eps33": eps33}),
        )
    yield "d33 = 0", "no constants but those that the paper gives", _with_d(ceramic, 0.0, 1.0)
    yield "d31 x 2", "more coupling than there is field", _with_d31(ceramic, 2.0)


def material_effects(
    scene: Scene, announce: Callable[[str], None], *, level: int = 1
) -> list[MaterialRow]:
    """Row per choice of the scene's tensor, solved on the scene's support."""
    rows = []
    for name, what, ceramic in choices(scene.piezo.ceramic()):
        try:
            ceramic.check_admissible()
        except InputError as error:
            rows.append(MaterialRow(name, what, refused=str(error)))
            continue
        announce(f"material: {name}")
        values = solid_values(SolidCase(scene, ceramic, level=level))
        reduced = scene.piezo.model_copy(update=ceramic.reduced())
        beam = beam_values(scene.model_copy(update={"piezo": reduced}))
        rows.append(MaterialRow(name, what, values, beam))
    return rows


def _with_d(ceramic: Piezoceramic, d33: float, d15: float) -> Piezoceramic:
    d = ceramic.d.copy()
    d[2, 2] *= d33
    d[0, 4] *= d15
    d[1, 3] *= d15
    return replace(ceramic, d=d)


def _with_d31(ceramic: Piezoceramic, factor: float) -> Piezoceramic:
    d = ceramic.d.copy()
    d[2, :2] *= factor
    return replace(ceramic, d=d)


def _with_s12(ceramic: Piezoceramic, ratio: float) -> Piezoceramic:
    s = ceramic.s.copy()
    s[0, 1] = s[1, 0] = -ratio * s[0, 0]
    s[5, 5] = 2.0 * (s[0, 0] - s[0, 1])
    return replace(ceramic, s=s)


def _scaled(ceramic: Piezoceramic, place: tuple[int, int], factor: float) -> Piezoceramic:
    """Ceramic with s13 (and its equals) or s33 scaled."""
    s = ceramic.s.copy()
    places = {place, place[::-1]} | ({(1, 2), (2, 1)} if place == (0, 2) else set())
    for i, j in places:
        s[i, j] *= factor
    return replace(ceramic, s=s)
