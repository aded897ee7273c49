"""The magnetic pull of a device by its reluctance network, for whoever asks no field model."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from tactgen.geometry.device.parameters import Coil, Device, Rod, Sleeve, Spring, Steel

if TYPE_CHECKING:
    from tactgen.tmm.reluctance.coenergy.map import CoenergyMap


def network_pull(device: Device) -> CoenergyMap:
    """Return the network's co-energy map of a device, made once for one magnetic circuit.

    Raises
    ------
    InputError
        If the parts cannot form the circuit.
    """
    coil = device.coil.model_copy(update={"history": "rising"})  # no matter to the circuit
    return _network_pull(device.rod, coil, device.sleeve, device.spring, device.steel, device.gap)


@lru_cache(maxsize=32)
def _network_pull(
    rod: Rod, coil: Coil, sleeve: Sleeve, spring: Spring, steel: Steel, gap: float
) -> CoenergyMap:
    from tactgen.tmm.reluctance.coenergy.fit import fit
    from tactgen.tmm.reluctance.map_range import map_grid
    from tactgen.tmm.reluctance.network import network_samples

    circuit = Device(rod=rod, coil=coil, sleeve=sleeve, spring=spring, steel=steel, gap=gap)
    return fit(network_samples(circuit, *map_grid(circuit)))
