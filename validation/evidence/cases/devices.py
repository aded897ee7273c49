"""Benders and harvesters that others built and measured, beside bands of predictions.

What a source does not state lies anywhere in a range.  Each unknown's effect on a number is solved
at both ends of its range; the effects multiply, and the band holds 95 % of the products.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache, partial
from statistics import geometric_mean
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.ceramic_library import CERAMICS, LIBRARY
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.case import Case, Check, Null, case, middle
from tactgen.validation.models.model import Estimate
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.published_measurements import Figure, Published, Unknown, Values

_SAMPLES = 1024
_MILLI, _MICRO = 1e-3, 1e-6


#: The last unknown of each device: the models between which its answer lies.
_MODEL = Unknown("model", 0.0, 1.0, "1", "a beam at 0, the solid at 1", 0.0)


@cache
def bands(device: Figure) -> Floats:
    """Ends (numbers, 2) of the bands that hold 95 % of the predictions."""
    from scipy.stats.qmc import Sobol  # slow to import

    usual = {u.name: u.usual for u in device.unknowns}
    centre = device.predict(usual)
    shares = Sobol(len(device.unknowns), seed=1).random(_SAMPLES)
    logarithms = np.zeros((_SAMPLES, centre.size))
    for unknown, share in zip(device.unknowns, shares.T, strict=True):
        values = np.array([unknown.low, unknown.usual, unknown.high])
        found = [device.predict(usual | {unknown.name: float(v)}) for v in values[[0, 2]]]
        logs = np.log(np.array([found[0], centre, found[1]]) / centre)
        at = unknown.at(share)
        logarithms += np.stack([np.interp(at, values, column) for column in logs.T], axis=1)
    return np.asarray(np.quantile(centre * np.exp(logarithms), [0.025, 0.975], axis=0).T)


def _band(device: Figure, number: int) -> Estimate:
    return middle(bands(device)[number])


def _solved(settings: Iterable[str], values: Values, *quantities: str) -> list[float]:
    """Sizes of quantities (SI), of a list of modes the first."""
    model = "solid" if values[_MODEL.name] else "tmm"
    scene, _ = load_scene("j1", (*settings, f"models={model}", "modes=1"))
    found = solve(scene, (model,), quantities, modelling=False)
    return [float(np.abs(np.ravel(found.get(name, model).value)[0])) for name in quantities]


def _share(name: str, by: float, reason: str) -> Unknown:
    """Factor on a number that is stated."""
    return Unknown(name, 1.0 - by, 1.0 + by, "1", reason, 1.0)


def _around(words: str, value: float, by: float, unit: str) -> Published:
    return Published(words, (1.0 - by) * value, (1.0 + by) * value, unit)


#: A ceramic's constants that a beam reads, and their units.
_CERAMIC = {"s11": "m^2/N", "d31": "C/N", "eps33": "", "density": "kg/m^3"}


def _constants(values: Values) -> list[str]:
    """Settings of a ceramic's constants (SI)."""
    return [f"piezo.{key}={values[key]:.9g} {unit}".rstrip() for key, unit in _CERAMIC.items()]


def _ceramic() -> list[Unknown]:
    """How far the constants of a ceramic of the trade may be off."""
    return [_share(key, CERAMICS[key].share, f"assumed: {CERAMICS[key].kind}") for key in _CERAMIC]


# --- multilayer benders of data sheets ---------------------------------------------------------


class _Sheet(NamedTuple):
    """A family of benders: where its numbers stand, and how far they may be off."""

    source: str
    ceramic: str
    volts: float  #: Amplitude about the middle electrode
    height_by: tuple[float, str]  #: m either way, and why
    stroke_by: float
    force_by: float
    capacitance_by: float
    frequency_by: float


class _Bender(NamedTuple):
    """A bender as printed: mm, µm, N, µF of each half, Hz."""

    name: str
    length: float
    free: float
    width: float
    height: float
    stroke: float
    force: float
    half_capacitance: float
    frequency: float


_PICMA = _Sheet(
    "Physik Instrumente, PICMA Bender PL112 - PL140, data sheet of 31.07.2020", "PIC255", 30.0,
    (0.1e-3, "data sheet: ± 0.1 mm"), 0.2, 0.2, 0.2, 0.2,
)  # fmt: skip
_CTS = _Sheet(
    "CTS, Bending Actuators - Plate Benders, data sheet RevC_0524", "NCE51", 100.0,
    (0.05e-3, "assumed: half of what another maker states"), 0.15, 0.2, 0.15, 0.1,
)  # fmt: skip
_SHEETS = {
    _PICMA: (
        _Bender("PL112.10", 18.0, 12.0, 9.60, 0.67, 100.0, 2.1, 1.1, 1800.0),
        _Bender("PL122.10", 25.0, 22.0, 9.60, 0.67, 310.0, 1.25, 2.5, 600.0),
        _Bender("PL127.10", 31.0, 27.0, 9.60, 0.67, 450.0, 1.1, 3.4, 420.0),
        _Bender("PL128.10", 36.0, 28.0, 6.15, 0.67, 450.0, 0.55, 1.2, 360.0),
        _Bender("PL140.10", 45.0, 40.0, 11.0, 0.55, 1000.0, 0.5, 4.1, 160.0),
    ),
    _CTS: (
        _Bender("NAC2221", 21.0, 17.5, 7.8, 0.7, 210.0, 1.5, 0.105, 920.0),
        _Bender("NAC2224", 32.0, 28.5, 7.8, 0.7, 530.0, 0.92, 0.170, 340.0),
        _Bender("NAC2225", 32.0, 28.5, 7.8, 1.3, 365.0, 3.4, 0.350, 620.0),
        _Bender("NAC2226", 32.0, 28.5, 7.8, 1.8, 250.0, 6.2, 0.520, 890.0),
        _Bender("NAC2227", 50.0, 46.5, 7.8, 0.7, 1490.0, 0.58, 0.280, 130.0),
        _Bender("NAC2229", 50.0, 46.5, 7.8, 1.8, 700.0, 4.0, 0.860, 330.0),
    ),
}  # fmt: skip


def _bender(sheet: _Sheet, bender: _Bender) -> Figure:
    """Bender of many thin layers, whose thickness follows from the capacitance.

    As a beam, n layers at V across each half are one at n V with the capacitance over n².
    """
    constants = LIBRARY[sheet.ceramic].reduced()
    height, stroke = bender.height * _MILLI, bender.stroke * _MICRO

    def predict(values: Values) -> Floats:
        half = 0.5 * height * values["height"]
        free = bender.free * _MILLI * values["free length"]
        settings = [
            f"bimorph.layers=piezo {half:.9g} m +x; piezo {half:.9g} m +x",
            f"bimorph.length={free:.9g} m",
            f"bimorph.width={bender.width * values['width']:.9g} mm",
            f"piezo.material={sheet.ceramic}",
        ]
        settings += _constants({key: constants[key] * values[key] for key in _CERAMIC})
        deflection, force, capacitance, frequency = _solved(
            settings, values, "static_tip_displacement", "blocked_force", "capacitance_free",
            "short_circuit_frequencies",
        )  # fmt: skip
        printed = 2.0 * bender.half_capacitance * _MICRO * values["capacitance"]
        layers = np.sqrt(printed / (capacitance * values["electrodes"]))
        grown = values["d31 at the full voltage"]
        return np.array([deflection * layers * sheet.volts * grown, force / deflection, frequency])

    by, why = sheet.height_by
    unknowns = (
        _share("height", by / height, why),
        _share("width", 0.02, "Physik Instrumente: ± 0.2 mm of 9.6 mm"),
        _share("free length", 0.5 / bender.free, "assumed: clamped to within ± 0.5 mm"),
        *_ceramic(),
        _share("capacitance", sheet.capacitance_by, "data sheet"),
        Unknown("electrodes", 1.0, bender.length / bender.free, "1",
                "their length over the free length; at most the whole bender", 1.0),
        Unknown("d31 at the full voltage", 1.0, 1.8, "1",
                "over that of small signals, assumed: a soft ceramic at 1 kV/mm", 1.4),
        _MODEL,
    )  # fmt: skip
    stiffness_by = float(np.hypot(sheet.stroke_by, sheet.force_by))
    numbers = (
        _around("stroke at full voltage", stroke, sheet.stroke_by, "m"),
        _around("blocking force over stroke", bender.force / stroke, stiffness_by, "N/m"),
        _around("resonance", bender.frequency, sheet.frequency_by, "Hz"),
    )
    return Figure(bender.name, sheet.source, numbers, unknowns, predict)


# --- harvesters --------------------------------------------------------------------------------


class _Harvester(NamedTuple):
    """Two layers in series on brass as printed: mm, GPa, pC/N, kg/m³, g; resonances in Hz."""

    name: str
    source: str
    length: float
    width: float
    layer: float
    brass: float
    modulus: float
    d31: float
    eps33: float
    density: float
    tip_mass: float
    short: float
    open: float


# printed as e31 -16.6 C/m² and eps33S 25.55 nF/m
_BARE = _Harvester(
    "PZT-5H", "Erturk and Inman, Piezoelectric Energy Harvesting (2011), chapter 4: a bimorph of "
    "PZT-5H by Piezo Systems", 24.53, 6.4, 0.265, 0.14, 60.6, -273.9, 3399.0, 7500.0, 0.0,
    502.5, 524.7,
)  # fmt: skip
_HARVESTERS = (
    _Harvester(
        "PZT-5A with a tip mass", "Erturk and Inman, Smart Mater. Struct. 18 (2009) 025009",
        50.8, 31.8, 0.26, 0.14, 66.0, -190.0, 1500.0, 7800.0, 12.0, 45.6, 48.4,
    ),
    _BARE,
    _BARE._replace(name="PZT-5H with a tip mass", tip_mass=0.239, short=338.4, open=356.3),
)  # fmt: skip
#: Brass: modulus (GPa) and density (kg/m³) as printed.
_BRASS = 105.0, 9000.0


def _harvester(harvester: _Harvester) -> Figure:
    """Cantilever in series, from short circuit (1 kohm) to open circuit (470 kohm)."""
    usual = {
        "s11": 1e-9 / harvester.modulus, "d31": 1e-12 * harvester.d31, "eps33": harvester.eps33,
        "density": harvester.density,
    }  # fmt: skip

    def predict(values: Values) -> Floats:
        modulus = _BRASS[0] * values["brass"]
        settings = [
            "bimorph.wiring=series", "piezo.material=PZT-5A",
            f"bimorph.length={harvester.length * values['free length']:.9g} mm",
            f"bimorph.width={harvester.width} mm",
            f"bimorph.piezo_thickness={harvester.layer * values['layers']:.9g} mm",
            f"bimorph.shim_thickness={harvester.brass} mm",
            f"shim.youngs_modulus={modulus:.9g} GPa",
            f"shim.shear_modulus={modulus / 2.6:.9g} GPa", f"shim.density={_BRASS[1]} kg/m^3",
            *_constants({key: usual[key] * values[key] for key in _CERAMIC}),
        ]  # fmt: skip
        if harvester.tip_mass:
            settings += [
                "load.kind=mass", f"load.mass={harvester.tip_mass} g",
                f"load.offset={values['centre of the mass']:.9g} m",
            ]  # fmt: skip
        return np.array(
            _solved(settings, values, "short_circuit_frequencies", "open_circuit_frequencies")
        )

    mass = Unknown("centre of the mass", -2e-3, 2e-3, "m",
                   "above the tip; assumed: the mass is on the last millimetres", 0.0)  # fmt: skip
    unknowns = (
        _share("free length", 0.5 / harvester.length, "assumed: clamped to within ± 0.5 mm"),
        _share("layers", 0.04, "assumed: 10 µm of a layer's thickness"),
        _share("brass", 0.05, "assumed: rolled brass, 100 to 110 GPa"),
        *_ceramic(),
        *([mass] if harvester.tip_mass else []),
        _MODEL,
    )
    numbers = (
        _around("resonance in short circuit", harvester.short, _FOUND, "Hz"),
        _around("resonance in open circuit", harvester.open, _FOUND, "Hz"),
    )
    return Figure(harvester.name, harvester.source, numbers, unknowns, predict)


#: Half of the last printed digit, and a peak found from a sweep.
_FOUND = 0.002


def _ranges(device: Figure) -> str:
    """Sentence on what is unknown of a device."""
    each = (f"{u.name} {u.low:.4g} to {u.high:.4g} {u.unit.strip('1')}".rstrip() + f" ({u.reason})"
            for u in device.unknowns[:-1])  # fmt: skip
    return (
        "What its source leaves open lies anywhere in a range, of each device its own.  Of "
        f"{device.title}, factors where there is no unit: {'; '.join(each)}."
    )


#: The one bender whose band of resonances begins above what was measured.
_LOW = next(bender for bender in _SHEETS[_CTS] if bender.name == "NAC2225")
_SOFT_CLAMP = (
    "all resonances of this maker are printed below their bands, and only the assumed "
    f"{100.0 * _CTS.frequency_by:.0f} % reach the others.  Were all of its {_LOW.length:g} mm "
    f"free, this one would be {100.0 * (1.0 - (_LOW.free / _LOW.length) ** 2):.0f} % lower: a "
    f"clamp of {_LOW.length - _LOW.free:g} mm that gives way is enough, and the clamp is rigid here"
)


def _family(name: str, title: str, problem: str, devices: tuple[Figure, ...], model: str) -> Case:
    """All numbers of a family's devices; those of one harvester take a second."""
    rows = []
    for device in devices:
        for number, published in enumerate(device.numbers):
            others = [d.numbers[number].middle for d in devices if d is not device]
            low = device.title == _LOW.name and published.words == "resonance"
            rows.append(Check(
                f"{device.title}: {published.words}.", (published.low, published.high),
                published.unit, partial(_band, device, number), source=device.source, band=True,
                known=0.0122 if low else 0.0, explained=_SOFT_CLAMP if low else "",
                heavy=device.title != _HARVESTERS[2].name,
                null=Null("the mean of the other devices", partial(geometric_mean, others)),
            ))  # fmt: skip
    return case(
        name, title, problem, rows, model=model, tier="validation",
        reason="the band and what was measured with its tolerance have a value in common; a "
        "tolerance that its source does not state is assumed",
    )  # fmt: skip


def _benders(name: str, sheet: _Sheet) -> Case:
    devices = tuple(_bender(sheet, bender) for bender in _SHEETS[sheet])
    return _family(
        name, f"Multilayer benders: {sheet.source.partition(',')[0]}",
        f"Benders of many thin layers of {sheet.ceramic} or its like, a clamped cantilever at "
        f"{sheet.volts:g} V about its middle electrode. Number and thickness of the layers are not "
        "published and follow from the capacitance, which therefore is no row. "
        + _ranges(devices[0]), devices, "models tmm and solid, one layer in each half",
    )  # fmt: skip


_HARVEST = tuple(map(_harvester, _HARVESTERS))
CASES: tuple[Case, ...] = (
    _family(
        "HARV", "Harvesters: two layers of ceramic in series on brass",
        "Cantilevers on a shaker; resonances with 1 kohm and 470 kohm, near short and open "
        f"circuit. {_ranges(_HARVEST[-1])}", _HARVEST, "models tmm and solid",
    ),
    _benders("PICMA", _PICMA),
    _benders("CTSB", _CTS),
)  # fmt: skip
