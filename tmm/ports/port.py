"""Ports: a name, and the conjugate pair of variables through which power goes in.

Displacement and charge, not velocity and current, so that 0 Hz is an ordinary frequency.
Complex peak amplitudes, time factor e^{+jΩt}.
"""

from __future__ import annotations

from dataclasses import dataclass

from tactgen.geometry.store.values import storable


@storable
@dataclass(frozen=True)
class Pair:
    """Two conjugate variables: the motion is what is prescribed, the effort what answers.

    Attributes
    ----------
    motion, motion_unit : str
        Symbol and unit of what is equal in ports that are joined.
    effort, effort_unit : str
        Symbol and unit of what adds up there, acting on the element from outside.
    sign : float
        Of the effort in the symmetric form, where ½ Ω Im(motion* · sign · effort) is the mean
        power taken in (W).  A voltage is a rate of flux and its answer a charge, the other way
        round than force and displacement, so it has −1.
    """

    motion: str
    motion_unit: str
    effort: str
    effort_unit: str
    sign: float = 1.0


#: Across the axis, towards +x.
LATERAL = Pair("w", "m", "F", "N")
#: About y; u_z = x ψ in a section, so ψ ≈ −w' for a slender beam.
ROTATION = Pair("ψ", "rad", "M", "N m")
#: Along the axis, towards +z.
AXIAL = Pair("u", "m", "F", "N")
#: A voltage across electrodes, answered by the charge that they take.
VOLTAGE = Pair("U", "V", "Q", "C", sign=-1.0)
#: A current through a winding, answered by its flux linkage: as a voltage and its charge, the other
#: way round than force and displacement.
CURRENT = Pair("i", "A", "λ", "Wb", sign=-1.0)


@storable
@dataclass(frozen=True)
class Port:
    """A named place at which an element is moved, loaded, driven or joined."""

    name: str
    pair: Pair


#: The lateral actuator's, by whatever model.
BIMORPH = (
    Port("w_base", LATERAL),
    Port("psi_base", ROTATION),
    Port("w_tip", LATERAL),
    Port("psi_tip", ROTATION),
    Port("voltage", VOLTAGE),
)
