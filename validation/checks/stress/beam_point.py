"""One point of the beam's parameters, compared with 80-digit arithmetic."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np

from tactgen.geometry.bimorph.ends import Ends
from tactgen.tmm.beam.mounted_beam import mounted_response
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.beam.span import EPS, EXTENDED_EPS, EXTENDED_ROUNDINGS, error_bound
from tactgen.tmm.beam.timoshenko import condition, dynamic_stiffness
from tactgen.tmm.ports.elements import base_stiffness, tip_stiffness
from tactgen.validation.checks.cases import reference_beam as reference
from tactgen.validation.checks.cases import textbook_beam
from tactgen.validation.checks.stress.result import WANTED, Point

#: Condition number up to which the wanted accuracy is promised.
CONDITION_LIMIT = (WANTED - 2.0 * EPS) / (EXTENDED_ROUNDINGS * EXTENDED_EPS)

#: Entries of D that are not zero by symmetry.
_ENTRIES = tuple(set(product(range(5), repeat=2)) - {(0, 4), (4, 0), (2, 4), (4, 2)})
#: Magnitude below which a double loses digits, or becomes 0.
_UNDERFLOW = 1e-290


def point(beam: Section, length: float, frequency: float, ends: Ends, where: str) -> Point:
    """Compare D and the terminated response at one point."""
    omega = 2.0 * np.pi * frequency
    exact = reference.dynamic_stiffness(reference.constants(beam), length, omega)
    f = np.array([frequency])
    base = None
    if ends.base is not None:
        lateral, rotational = base_stiffness(ends.base, f)
        base = complex(lateral[0]), complex(rotational[0])
    tip = complex(tip_stiffness(ends.tip, f)[0])
    w_tip, charge, psi_tip = reference.tip_motion(exact, base, tip)
    ours = mounted_response(beam, length, omega, base=base, tip=tip)
    errors = [
        entry_error(dynamic_stiffness(beam, length, omega), exact),
        reference.relative_error(ours.w_tip, w_tip),
        reference.relative_error(ours.charge, charge),
        reference.relative_error(ours.psi_tip, psi_tip),
    ]
    worst = max(float(condition(beam, length, omega).max()), float(ours.condition))
    naive = math.nan
    if frequency > 0.0:
        velocity = textbook_beam.tip_velocity(beam, length, f, base=base, tip=tip)[0]
        naive = max(
            entry_error(textbook_beam.dynamic_stiffness(beam, length, f)[0], exact),
            _finite(reference.relative_error(velocity / (1j * omega), w_tip)),
        )
    return Point(where, max(errors), worst, float(error_bound(worst)), naive)


def entry_error(got: Any, exact: Any) -> float:
    """Return the worst relative error of the entries of D (5, 5); infinite for nan."""
    return max(
        _finite(reference.relative_error(got[at], exact[at]))
        for at in _ENTRIES
        if abs(exact[at]) > _UNDERFLOW
    )


def _finite(error: float) -> float:
    return math.inf if math.isnan(error) else error
