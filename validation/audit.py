"""The effect of each misprinted formula of Appendix A on numbers that a reader would use."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tmm.appendix_a import MISPRINTS, matrix_a, printed_section
from tmm.terminations import load_stiffness, termination
from tmm.transfer_matrix import sections
from validation.scene import Scene

Complex = NDArray[np.complexfloating[Any, Any]]

#: Frequencies at which the effects are stated (Hz).
AT = np.array([10.0, 100.0, 500.0, 1000.0])


def audit(scene: Scene) -> list[dict[str, Any]]:
    """Return one row per misprint: texts, and relative changes of tip velocity and current.

    Computed as the paper does it, with transfer matrices, for the scene's bimorph on the
    paper's springs under the finger.
    """
    correct = _response(scene, frozenset())
    rows = []
    for number, misprint in MISPRINTS.items():
        wrong = _response(scene, frozenset({number}))
        with np.errstate(invalid="ignore"):  # 0/0 without piezoelectric coupling: shown as n/a
            change = np.abs(wrong / correct - 1.0)
        rows.append({"misprint": misprint, "velocity": change[0], "current": change[1]})
    return rows


def _response(scene: Scene, misprints: frozenset[int]) -> Complex:
    """Return tip velocity and current (2, n) per volt from A with springs and finger."""
    support = scene.support.model_copy(update={"kind": "spring"})
    load = scene.load.model_copy(update={"kind": "finger"})
    section, length = sections(scene.device, support, scene.beam, lossy=True)[-1]
    section = printed_section(section, scene.device, misprints)
    a = matrix_a(section, length, AT, misprints)
    jw = 2j * np.pi * AT
    base = termination(support, load, AT).base
    assert base is not None
    r41, r32 = base[0] / jw, base[1] / jw
    l41 = load_stiffness(load, AT) / jw
    out = np.empty((2, AT.size), dtype=complex)
    for i in range(AT.size):
        # below: M = R32 psi', F = R41 v;  above: M = 0, F + L41 v = 0
        start = np.zeros((5, 3), dtype=complex)
        start[0, 0], start[3, 0] = 1.0, r41[i]
        start[1, 1], start[2, 1] = 1.0, r32[i]
        start[4, 2] = 1.0
        end = a[i] @ start
        conditions = np.stack([end[2], end[3] + l41[i] * end[0]])
        unknown = np.linalg.solve(conditions[:, :2], -conditions[:, 2])
        state = end @ np.array([*unknown, 1.0])
        out[:, i] = state[0], state[4]
    return out
