"""What people call things, and names as they write them: in any case, with slips of the pen."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

#: Longest name (characters) for which the nearest known one is looked for.
_LONGEST = 100
#: How alike (1: the same) a whole name is, a last part that stands for one, and either of a name
#: that is written otherwise: a short part alone says less.
_LIKE, _LIKE_LAST, _LIKE_WRITTEN = 0.5, 0.8, 0.6
#: Names that are suggested at most.
_SHOWN = 3
#: What people call things, as :func:`folded`, with the names that they mean here.  Spelling alone
#: would lead elsewhere.
_MEANT: dict[str, tuple[str, ...]] = {
    "acceleration": ("drive.base_acceleration", "tip_acceleration"),
    "baseexcitation": ("drive.base_acceleration",),
    "gravity": ("drive.base_acceleration",),
    "driveacceleration": ("drive.base_acceleration",),
    "driveforce": ("drive.tip_force",),
    "loadforce": ("drive.tip_force", "load_force"),
    "resistance": ("circuit.resistance", "optimum_resistance"),
    "loadresistance": ("circuit.resistance",),
    "loadresistor": ("circuit.resistance",),
    "driveresistance": ("circuit.resistance",),
    "capacitance": ("capacitance_free", "circuit.capacitance"),
    "electrodes": ("circuit.kind", "bimorph.layers"),
    "tipmass": ("load.mass",),
    "proofmass": ("load.mass",),
    "bimorphthickness": ("bimorph.piezo_thickness", "bimorph.shim_thickness"),
    "piezothickness": ("bimorph.piezo_thickness",),
    "shimthickness": ("bimorph.shim_thickness",),
    "substratethickness": ("bimorph.shim_thickness",),
    "piezoyoungsmodulus": ("piezo.s11",),
    "piezomodulus": ("piezo.s11",),
    "piezoe": ("piezo.s11",),
    "piezopermittivity": ("piezo.eps33",),
    "piezoepsilon33": ("piezo.eps33",),
    "piezoq": ("piezo.quality_factor",),
    "piezotandelta": ("piezo.loss_tangent",),
    "qm": ("piezo.quality_factor",),
    "q": ("piezo.quality_factor",),
    "cs": ("support.rotational_stiffness",),
    "csl": ("support.lateral_stiffness",),
    "ds": ("support.rotational_damping",),
    "theta": ("support.rotational_inertia",),
    "rhop": ("piezo.density",),
    "tan": ("piezo.loss_tangent",),
    "tand": ("piezo.loss_tangent",),
    "tandelta": ("piezo.loss_tangent",),
    "rho": ("piezo.density",),
    "dampingratio": ("piezo.quality_factor", "shim.loss_factor"),
    "piezodampingratio": ("piezo.quality_factor",),
    "fixed": ("clamped",),
    "resistor": ("load",),
    "harvester": ("load",),
    "epoxy": ("glue",),
    "optimalload": ("optimum_resistance",),
    "circuitr": ("circuit.resistance",),
    "patchlength": ("bimorph.layers",),
    "piezolength": ("bimorph.layers", "bimorph.length"),
    "rms": ("drive.voltage",),
    "pp": ("drive.voltage",),
    "voltagerms": ("drive.voltage",),
    "voltagepp": ("drive.voltage",),
    "wirediameter": ("coil.turns", "coil.fill_factor"),
    "coilwirediameter": ("coil.turns", "coil.fill_factor"),
    "airgap": ("gap",),
    "current": ("coil.current", "input_current"),
    "layers": ("bimorph.layers",),
    "unimorph": ("bimorph.layers",),
    "patch": ("bimorph.layers",),
    "deflection": ("tip_displacement", "static_tip_displacement"),
    "displacement": ("tip_displacement",),
    "velocity": ("tip_velocity",),
    "velocityrms": ("tip_velocity",),
    "resonance": ("short_circuit_frequencies",),
    "resonancefrequency": ("short_circuit_frequencies",),
    "naturalfrequency": ("short_circuit_frequencies", "open_circuit_frequencies"),
    "eigenfrequency": ("short_circuit_frequencies", "open_circuit_frequencies"),
    "eigenfrequencies": ("short_circuit_frequencies", "open_circuit_frequencies"),
    "modes": ("short_circuit_frequencies",),
    "voltage": ("drive.voltage", "electrode_voltage"),
    "outputvoltage": ("electrode_voltage",),
    "power": ("circuit_power", "load_power"),
    "sensitivity": ("voltage_per_force", "voltage_per_acceleration"),
    "charge": ("charge_per_force", "charge_per_acceleration"),
    "impedance": ("admittance", "coil_impedance"),
    "stress": ("ceramic_stress",),
    "force": ("blocked_force", "magnetic_force"),
    "stiffness": ("dynamic_stiffness",),
}


def folded(name: str) -> str:
    """Name without case, hyphens, underscores and spaces, to compare it with others."""
    return "".join(c for c in name.casefold() if c not in " -_")


def nearest(name: str, known: Iterable[str]) -> str:
    """`` (did you mean "…"?)`` for a misspelt name, or one of other words, or nothing.

    Of dotted names the last part may be all that was written; several may end in it.
    """
    known = tuple(known)
    if len(name) > _LONGEST:  # no slip of the pen; comparing takes its square in time
        return ""
    close = (
        [meant for meant in _MEANT.get(folded(name.replace(".", "")), ()) if meant in known]
        or ("." not in name and _of_ending(name, known, cutoff=_LIKE_LAST))
        or difflib.get_close_matches(name, known, n=1, cutoff=_LIKE)
        or _of_ending(name.rsplit(".", 1)[-1], known, cutoff=_LIKE_WRITTEN)
    )
    if not close:
        plain = {folded(k): k for k in known}
        alike = difflib.get_close_matches(folded(name), plain, n=1, cutoff=_LIKE_WRITTEN)
        close = [plain[f] for f in alike]
    if not close:
        return ""
    shown = ", ".join(f'"{k}"' for k in close[:_SHOWN])
    return f" (did you mean {shown}{', …' if len(close) > _SHOWN else ''}?)"


def _of_ending(ending: str, known: tuple[str, ...], *, cutoff: float) -> list[str]:
    """Dotted names whose last part is nearest to `ending`."""
    dotted = [(k, k.rsplit(".", 1)[-1]) for k in known if "." in k]
    close = difflib.get_close_matches(ending, [last for _, last in dotted], n=1, cutoff=cutoff)
    return [k for k, last in dotted if last in close]
