"""Constants of a piezoelectric material as data sheets print them, completed to full tensors.

A scene writes them as text such as ``"c11 127.2 GPa; e31 -6.62 C/m^2; eps33S 1433; k33 0.75"``, in
any mixture of forms (IEEE 176): compliances ``s``, stiffnesses ``c``, Young's moduli ``Y``, Poisson
ratios ``nu``, piezoelectric ``d``, ``e`` and ``g``, relative permittivities ``eps`` at constant
stress or (``S``) strain, coupling factors ``k``.  ``e31bar`` and ``eps33bar`` are those of a strip
that is strained along alone, ``e31f`` and ``eps33f`` of a film held on a substrate.  Elastic
constants are those at constant field, or (``D``) at constant displacement.  What is not stated
keeps its ratio to a base material.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BeforeValidator

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.materials import EPS0, Piezoceramic
from tactgen.geometry.device.parameter_group import NONE, read_list
from tactgen.geometry.errors import InputError
from tactgen.geometry.synonyms import nearest
from tactgen.geometry.units import NUMBER, Unit, quoted

_EXAMPLE = "s11 16.4e-12 m^2/N; d33 374 pC/N; k33 0.705"
_REMEDY = f'write for example "{_EXAMPLE}"'
_STATED = re.compile(
    rf"(?P<name>[A-Za-z]+\d*[A-Za-z]*)\s*[=:]?\s+(?P<value>{NUMBER}.*)", re.ASCII | re.DOTALL
)

#: Full tables are printed to three digits, and what follows from the others agrees to this.
_PRINTED_ALIKE = 0.02
#: What counts as having them all.
_EXACT = 1e-9
#: Relative change of a stated constant from which on it is told.
_WORTH_A_WORD = 5e-3
_STEPS, _HALVINGS, _CONVERGED = 60, 30, 1e-12


class Forms:
    """Tensors of one material in all forms (SI, IEEE 176 axes, permittivity in F/m)."""

    def __init__(self, s: Floats, d: Floats, eps_t: Floats) -> None:
        self.s, self.d, self.eps_t = s, d, eps_t

    @cached_property
    def c(self) -> Floats:
        """(6, 6) Stiffness at constant field (Pa)."""
        return np.asarray(np.linalg.inv(self.s))

    @cached_property
    def e(self) -> Floats:
        """(3, 6) Piezoelectric stress constants (C/m²)."""
        return np.asarray(self.d @ self.c)

    @cached_property
    def g(self) -> Floats:
        """(3, 6) Piezoelectric voltage constants (V m/N)."""
        return np.asarray(np.linalg.solve(self.eps_t, self.d))

    @cached_property
    def eps_s(self) -> Floats:
        """(3, 3) Permittivity at constant strain (F/m)."""
        return np.asarray(self.eps_t - self.e @ self.d.T)

    @cached_property
    def s_d(self) -> Floats:
        """(6, 6) Compliance at constant displacement (m²/N)."""
        return np.asarray(self.s - self.d.T @ self.g)

    @cached_property
    def c_d(self) -> Floats:
        """(6, 6) Stiffness at constant displacement (Pa)."""
        return np.asarray(np.linalg.inv(self.s_d))


_Value = Callable[[Forms], float]


def _entry(form: str, i: int, j: int, unit: float = 1.0) -> _Value:
    return lambda of: float(getattr(of, form)[i, j] / unit)


def _coupling(i: int, j: int) -> _Value:
    """Size of the coupling factor of a bar or a shear plate, k31 for (2, 0)."""
    return lambda of: float(abs(of.d[i, j]) / np.sqrt(of.s[j, j] * of.eps_t[i, i]))


def _modulus(i: int) -> _Value:
    return lambda of: float(1.0 / of.s[i, i])


def _kp(of: Forms) -> float:
    return float(abs(of.d[2, 0]) * np.sqrt(2.0 / ((of.s[0, 0] + of.s[0, 1]) * of.eps_t[2, 2])))


def _kt(of: Forms) -> float:
    return float(np.sqrt(1.0 - of.c[2, 2] / of.c_d[2, 2]))


def _held(directions: int, of: Forms) -> Floats:
    """Stress per field (n,) in C/m² where strain along 1, or along 1 and 2, is held at zero."""
    return np.linalg.solve(of.s[:directions, :directions], of.d[2, :directions])


def _held_e31(directions: int, of: Forms) -> float:
    """Charge per area and strain along 1 (C/m²), the other directions free."""
    return float(_held(directions, of)[0])


def _held_eps33(directions: int, of: Forms) -> float:
    """Relative permittivity while that strain is held at zero."""
    stored = of.d[2, :directions] @ _held(directions, of)
    return float((of.eps_t[2, 2] - stored) / EPS0)


class _Kind(NamedTuple):
    unit: Unit
    value: _Value


def _kinds() -> Iterator[tuple[str, _Kind]]:
    """Every constant that can be stated, by name."""
    compliance = Unit("1/Pa", "elastic compliance", "16.4e-12 m^2/N", shown="m^2/N")
    stiffness = Unit("Pa", "stiffness", "127 GPa", shown="GPa")
    strain = Unit("m/V", "piezoelectric constant", "-171 pC/N", shown="pC/N")
    stress = Unit("C/m**2", "piezoelectric constant", "-6.62 C/m^2", shown="C/m^2")
    voltage = Unit("V*m/N", "piezoelectric constant", "-11e-3 V*m/N", shown="V*m/N")
    permittivity = Unit("", "relative permittivity", "1700", at_least=1.0)
    factor = Unit("", "coupling factor", "0.344", at_least=0.0, below=1.0)
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2), (3, 3), (4, 4), (5, 5)):
        at = f"{i + 1}{j + 1}"
        yield f"s{at}", _Kind(compliance, _entry("s", i, j))
        yield f"s{at}D", _Kind(compliance, _entry("s_d", i, j))
        yield f"c{at}", _Kind(stiffness, _entry("c", i, j))
        yield f"c{at}D", _Kind(stiffness, _entry("c_d", i, j))
    for i, j in ((2, 0), (2, 1), (2, 2), (0, 4), (1, 3)):
        at = f"{i + 1}{j + 1}"
        yield f"d{at}", _Kind(strain, _entry("d", i, j))
        yield f"e{at}", _Kind(stress, _entry("e", i, j))
        yield f"g{at}", _Kind(voltage, _entry("g", i, j))
        yield f"k{at}", _Kind(factor, _coupling(i, j))
    for i in range(3):
        at = f"{i + 1}{i + 1}"
        yield f"eps{at}", _Kind(permittivity, _entry("eps_t", i, i, EPS0))
        yield f"eps{at}S", _Kind(permittivity, _entry("eps_s", i, i, EPS0))
        modulus = Unit("Pa", "modulus", "61 GPa", above=0.0, shown="GPa")
        yield f"Y{at}", _Kind(modulus, _modulus(i))
    for name, directions in (("bar", 1), ("f", 2)):
        yield f"e31{name}", _Kind(stress, partial(_held_e31, directions))
        yield f"eps33{name}", _Kind(permittivity, partial(_held_eps33, directions))
    poisson = Unit("", "Poisson ratio", "0.35", above=-1.0, below=1.0)
    yield "nu12", _Kind(poisson, lambda of: float(-of.s[0, 1] / of.s[0, 0]))
    yield "nu13", _Kind(poisson, lambda of: float(-of.s[0, 2] / of.s[0, 0]))
    yield "kp", _Kind(factor, _kp)
    yield "kt", _Kind(factor, _kt)


_KINDS = dict(_kinds())
#: Keys of the scene for what data sheets print beside these.
_OTHER_KEYS = ("piezo.density", "piezo.quality_factor", "piezo.loss_tangent")


class Constant(NamedTuple):
    """One stated constant (SI; permittivities relative)."""

    name: str
    value: float

    def __str__(self) -> str:
        return f"{self.name} {_KINDS[self.name].unit.show(self.value)}"


class Constants(tuple[Constant, ...]):
    """Stated constants; empty where the base material says all."""

    __slots__ = ()

    def __str__(self) -> str:
        return "; ".join(map(str, self)) or NONE


NO_CONSTANTS = Constants()


def read_constants(value: Any) -> Constants:
    """Constants from their text, a list of texts, or constants.

    Raises ValueError with a sentence that names the remedy.
    """
    found: Constants = read_list(value, Constants, Constant, _constant, _REMEDY)
    names = [one.name for one in found]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"states {name} twice; leave one of them out")
    return found


def _constant(text: str) -> Constant:
    parts = _STATED.fullmatch(text)
    if parts is None:
        raise ValueError(f"has {quoted(text)}, which is not a name and a value; {_REMEDY}")
    name = parts["name"]
    plain = _plain(name)
    if plain not in _KINDS:
        raise ValueError(
            f"has {quoted(name)}, which is not a known constant"
            f"{nearest(name, (*_KINDS, *_OTHER_KEYS))}; use s, c, "
            "Y, d, e, g, eps or k with their indices, with D at constant displacement and S at "
            "constant strain, or e31bar, e31f, eps33bar, eps33f, nu12, nu13, kp, kt"
        )
    unit = _KINDS[plain].unit
    try:
        number = _relative(parts["value"]) if plain.startswith("eps") else None
        number = unit.parse(parts["value"]) if number is None else number
        unit.check(number)
    except ValueError as error:
        raise ValueError(f"has {quoted(text)}, which {error}") from None
    return Constant(plain, number)


def _relative(text: str) -> float | None:
    """Relative permittivity of one that is stated in F/m; None of any other text."""
    try:
        return Unit("F/m", "permittivity", "13.3 nF/m").parse(text) / EPS0
    except ValueError:
        return None


#: Superscripts that stand before the indices, and names of the relative permittivity.
_SUPERSCRIPT = re.compile(r"([scY]|eps)([EDTS])(\d\d)")
_PERMITTIVITY = {"KT": "eps33", "K3T": "eps33", "K33T": "eps33", "K33S": "eps33S"}


def _plain(name: str) -> str:
    """Name without superscripts that are understood, such as sE11, s11E, epsT33 and KT."""
    name = _PERMITTIVITY.get(name, name)
    if parts := _SUPERSCRIPT.fullmatch(name):
        name = parts[1] + parts[3] + parts[2]
    if name.startswith("E"):  # a modulus or e, as its writer knows
        return name
    known = {of.lower(): of for of in _KINDS}
    kept = name.removesuffix("T") if name.startswith("eps") else name.removesuffix("E")
    return known.get(kept.lower(), kept)


StatedConstants = Annotated[Any, BeforeValidator(read_constants)]


# ---- completing them ----

#: Unknowns of the tensors: what a constant that is not stated keeps.  The first ten describe a
#: poled ceramic (class 6mm), the others what differs between its two directions across (mm2).
_UNKNOWNS = (
    "s11", "s12/s11", "s13/s11", "s33/s11", "s55/s11", "d31", "k33", "k15", "eps33", "eps11/eps33",
    "s22/s11", "s23/s13", "s44/s55", "s66", "d32/d31", "d24/d15", "eps22/eps11",
)  # fmt: skip
_OF_CERAMIC = 10
#: Unknowns that a constant is there to say, by its letter's kind and its indices.
_SAYS = {
    "elastic": {
        "11": "s11", "12": "s12/s11", "13": "s13/s11", "33": "s33/s11", "55": "s55/s11",
        "44": "s55/s11", "66": "s12/s11", "22": "s22/s11", "23": "s23/s13",
    },
    "piezoelectric": {
        "31": "d31", "33": "k33", "15": "k15", "24": "k15", "32": "d32/d31",
        "p": "d31", "t": "k33",
    },
    "dielectric": {"33": "eps33", "11": "eps11/eps33", "22": "eps11/eps33"},
}  # fmt: skip
#: The second of two directions across, which is an unknown where the first is stated as well.
_SECOND = {
    ("elastic", "44"): ("55", "s44/s55"), ("elastic", "66"): ("12", "s66"),
    ("piezoelectric", "24"): ("15", "d24/d15"), ("dielectric", "22"): ("11", "eps22/eps11"),
}  # fmt: skip


#: What a table of a ceramic shows: a full set, and what is printed beside it.
_TABLE = (
    "s11", "s12", "s13", "s33", "s55", "s66", "d31", "d33", "d15", "eps11", "eps33", "eps33S",
    "k31", "k33", "kp", "Y11",
)  # fmt: skip


def tabulated(of: Piezoceramic, names: Iterable[str] = _TABLE) -> Constants:
    """Constants of a ceramic as a data sheet prints them, to four digits."""
    forms = Forms(of.s, of.d, of.eps_t)
    return Constants(Constant(name, float(f"{_KINDS[name].value(forms):.4g}")) for name in names)


def _ratio(first: float, second: float) -> float:
    return float(first / second) if second else 1.0


def _unknowns(of: Piezoceramic) -> Floats:
    s, d, eps = of.s, of.d, np.diag(of.eps_t)
    return np.array([
        s[0, 0], s[0, 1] / s[0, 0], s[0, 2] / s[0, 0], s[2, 2] / s[0, 0], s[4, 4] / s[0, 0],
        d[2, 0], d[2, 2] / np.sqrt(s[2, 2] * eps[2]), d[0, 4] / np.sqrt(s[4, 4] * eps[0]), eps[2],
        eps[0] / eps[2], s[1, 1] / s[0, 0], s[1, 2] / s[0, 2], s[3, 3] / s[4, 4],
        s[5, 5] / (2.0 * (s[0, 0] - s[0, 1])), _ratio(d[2, 1], d[2, 0]), _ratio(d[1, 3], d[0, 4]),
        eps[1] / eps[0],
    ])  # fmt: skip


def _forms(unknowns: Floats) -> Forms:
    (
        s11, r12, r13, r33, r55, d31, k33, k15, eps33, e11, r22, r23, r44, r66, u32, u24, e22,
    ) = unknowns  # fmt: skip
    s, d = np.zeros((6, 6)), np.zeros((3, 6))
    s12, s13 = r12 * s11, r13 * s11
    s[:3, :3] = [[s11, s12, s13], [s12, r22 * s11, r23 * s13], [s13, r23 * s13, r33 * s11]]
    s55, eps11 = r55 * s11, e11 * eps33
    s[3, 3], s[4, 4], s[5, 5] = r44 * s55, s55, r66 * 2.0 * (s11 - s12)
    with np.errstate(invalid="ignore"):  # of no material, which is then refused
        d[2, :3] = d31, u32 * d31, k33 * np.sqrt(s[2, 2] * eps33)
        d[0, 4] = k15 * np.sqrt(s55 * eps11)
    d[1, 3] = u24 * d[0, 4]
    return Forms(s, d, np.diag([eps11, e22 * eps11, eps33]))


_PARTS = re.compile(r"(?P<letter>eps|nu|[scYdegk])(?P<at>\d\d|[pt])(?:[DSf]|bar)?")


def _said(constants: Sequence[Constant], base: Piezoceramic) -> list[int]:
    """Unknowns that the constants are there to say."""
    keys = []
    for name, _ in constants:
        parts = _PARTS.fullmatch(name)
        assert parts is not None
        letter = parts["letter"]
        kind = {"eps": "dielectric"}.get(letter, "piezoelectric" if letter in "degk" else "elastic")
        keys.append((kind, parts["at"]))
    found = set()
    for kind, at in keys:
        first, second = _SECOND.get((kind, at), ("", ""))
        plane = at != "66" or not base.isotropic_across or (kind, "22") in keys
        both = (kind, first) in keys and plane
        found.add(second if both else _SAYS[kind][at])
    return sorted(_UNKNOWNS.index(name) for name in found)


def completed(base: Piezoceramic, constants: Sequence[Constant]) -> Piezoceramic:
    """`base` with the stated constants; what they leave open keeps its ratio to `base`.

    Compliances keep their ratios to s11, d31 its value, d33 and d15 their coupling factors, eps11
    its ratio to eps33.  Where that leaves no solution, as for d31 with k31, all may move, as
    little as possible.

    Raises InputError if the constants contradict each other by more than tables of three digits
    do, in a sentence that names one of them.
    """
    if not constants:
        return base
    forms, misfit = _fitted(base, constants)
    if not misfit.max() <= _PRINTED_ALIKE:
        raise InputError(_contradiction(base, constants))
    origin = f"from piezo.constants, the rest by ratio to {base.name}"
    return replace(
        base, s=forms.s, d=forms.d, eps_t=forms.eps_t, origin=origin, stated={}, spreads={}
    )


def moved(of: Piezoceramic, constants: Sequence[Constant]) -> list[str]:
    """What a ceramic has in place of stated constants that contradict each other, in words."""
    forms, found = _forms(_unknowns(of)), []
    for one in constants:
        kind = _KINDS[one.name]
        value = kind.value(forms)
        if abs(value - one.value) > _WORTH_A_WORD * abs(one.value):
            found.append(f"{one.name} {kind.unit.show(float(f'{value:.4g}'))} in place of {one}")
    return found


def _fitted(base: Piezoceramic, constants: Sequence[Constant]) -> tuple[Forms, Floats]:
    """Tensors nearest to the base's that have the constants, and what each is off by, relative."""
    said = _said(constants, base)
    for free in (said, sorted({*range(_OF_CERAMIC), *said})):
        unknowns, misfit = _solved(_unknowns(base), free, constants)
        if misfit.max() < _EXACT:
            break
    return _forms(unknowns), misfit


def _solved(
    start: Floats, free: Sequence[int], constants: Sequence[Constant]
) -> tuple[Floats, Floats]:
    """Gauss-Newton steps of least length in the free unknowns, relative to where they start."""
    sizes = np.where(start == 0.0, 1.0, np.abs(start))[list(free)]

    def at(moved: Floats) -> Floats:
        unknowns = start.copy()
        unknowns[list(free)] += sizes * moved
        return unknowns

    def off(moved: Floats) -> Floats:
        with np.errstate(all="ignore"):
            forms = _forms(at(moved))
            found = np.array([_KINDS[name].value(forms) for name, _ in constants])
        return np.asarray((found - stated) / scale)

    stated = np.array([value for _, value in constants])
    base = np.array([_KINDS[name].value(_forms(start)) for name, _ in constants])
    scale = np.where(stated != 0.0, np.abs(stated), np.where(base != 0.0, np.abs(base), 1.0))
    moved = np.zeros(len(free))
    now = off(moved)
    for _ in range(_STEPS):
        slope = np.column_stack([
            (off(moved + step) - off(moved - step)) / 2e-6 for step in 1e-6 * np.eye(len(free))
        ])  # fmt: skip
        if not np.isfinite(slope).all():
            break
        step = np.linalg.lstsq(slope, -now, rcond=1e-9)[0]
        for _ in range(_HALVINGS):
            then = off(moved + step)
            if np.isfinite(then).all() and np.linalg.norm(then) <= np.linalg.norm(now):
                break
            step = 0.5 * step
        else:
            break
        moved, now = moved + step, then
        if np.abs(step).max() < _CONVERGED:
            break
    return at(moved), np.abs(now)


def _contradiction(base: Piezoceramic, constants: Sequence[Constant]) -> str:
    """Name the constant that is off by least from what the others give, of two alike the last."""
    found, least = "", np.inf
    for odd in constants if len(constants) > 1 else ():
        forms, misfit = _fitted(base, [one for one in constants if one is not odd])
        if not misfit.max() <= _PRINTED_ALIKE:
            continue
        kind = _KINDS[odd.name]
        value = kind.value(forms)
        off = abs(np.log(odd.value / value)) if odd.value * value > 0.0 else 1e3
        if off <= 1.001 * least:
            shown = kind.unit.show(float(f"{value:.4g}"))
            found, least = f"{odd}, where the others give {shown}; leave one of them out", off
    if found:
        return f"piezo.constants has {found}"
    return (
        f"piezo.constants = {quoted(str(Constants(constants)))} is no material: the constants "
        "contradict each other; check their units and signs"
    )
