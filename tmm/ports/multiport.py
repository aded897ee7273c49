"""Multiports, D(Ω) over named ports, and the algebra that joins, loads and drives them.

    efforts = D(Ω) · motions;   of the lateral actuator, by whatever model,
    [F_base, M_base, F_tip, M_tip, Q] = D(Ω) · [w_base, ψ_base, w_tip, ψ_tip, U]

Efforts act on the element from outside, each conjugate to its motion.  Everything attached
later (support, load, wiring, another element) is a few operations per frequency and never
needs a new field solution.
"""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.values import storable


@storable
@dataclass(frozen=True)
class Pair:
    """Port: two conjugate variables, a prescribed motion and its effort."""

    #: Symbol and unit of what is equal in ports that are joined
    motion: str
    motion_unit: str
    #: Symbol and unit of what adds up there, acting on the element from outside
    effort: str
    effort_unit: str
    #: Of the effort in the symmetric form, where ½ Ω Im(motion* · sign · effort) is the mean power
    #: taken in (W).  A voltage is a rate of flux and its answer a charge, the other way round than
    #: force and displacement, so it has −1
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
#: The place below the tip at which its motion is measured, if one is asked for: nothing acts there.
MEASURED = Port("w_measured", LATERAL)


@storable
@dataclass(frozen=True)
class Multiport:
    """Dynamic stiffness over named ports.

    Attributes
    ----------
    Raises InputError if two ports have one name.
    """

    frequencies: Floats  #: (n,) Frequencies (Hz); 0 is allowed, the static limit is finite
    stiffness: Complex  #: (n, k, k) complex D(Ω) in the units of effort per motion
    ports: tuple[Port, ...]  #: The k ports in order

    def __post_init__(self) -> None:
        twice = [name for name, count in Counter(self.names).items() if count > 1]
        if twice:
            raise InputError(f'two ports are named "{twice[0]}"; rename one of them')

    def __getitem__(self, entry: tuple[str, str]) -> Complex:
        """One entry (n,) of D: the effort at a port per motion at another."""
        row, column = entry
        return self.stiffness[:, self.index(row), self.index(column)]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The ports' names in order."""
        return tuple(port.name for port in self.ports)

    @property
    def omega(self) -> Floats:
        """Angular frequencies (n,) in rad/s."""
        return 2.0 * np.pi * self.frequencies

    def index(self, name: str) -> int:
        """Position of a port.

        Raises InputError with the nearest name, if there is no such port.
        """
        if name in self.names:
            return self.names.index(name)
        close = difflib.get_close_matches(name, self.names, n=1)
        hint = f' (did you mean "{close[0]}"?)' if close else ""
        raise InputError(f'port "{name}" is unknown{hint}; there are {", ".join(self.names)}')

    def others(self, names: Iterable[str]) -> list[str]:
        """Ports that are not named, in order."""
        named = {self.index(name) for name in names}
        return [name for i, name in enumerate(self.names) if i not in named]

    def block(self, *names: str) -> Multiport:
        """Rows and columns of some ports in that order, all others held."""
        at = [self.index(name) for name in names]
        stiffness = self.stiffness[:, at][:, :, at]
        return Multiport(self.frequencies, stiffness, tuple(self.ports[i] for i in at))

    def renamed(self, names: Mapping[str, str]) -> Multiport:
        """Copy with ports renamed by {old: new}."""
        new = {self.index(old): name for old, name in names.items()}
        ports = (replace(p, name=new.get(i, p.name)) for i, p in enumerate(self.ports))
        return replace(self, ports=tuple(ports))


def hold(port: Multiport, *names: str) -> Multiport:
    """Multiport with some motions held at 0; of a voltage: short-circuited."""
    return port.block(*port.others(names))


def terminate(port: Multiport, loads: Mapping[str, Any]) -> Multiport:
    """Multiport with something that answers at some ports, which stay ports.

    `loads` are ports with the effort per motion, a number or (n,) complex, of what is attached.
    """
    d = port.stiffness.copy()
    for name, stiffness in loads.items():
        at = port.index(name)
        d[:, at, at] += stiffness
    return replace(port, stiffness=d)


def in_series(port: Multiport) -> Multiport:
    """Port seen when the two equal layers are wired in series.

    Each layer then takes half the voltage and both carry the same charge.  Exact for
    a device that is mirror-symmetric about x = 0.
    """
    half = np.array([0.5 if p.pair == VOLTAGE else 1.0 for p in port.ports])
    return replace(port, stiffness=port.stiffness * half[:, None] * half)


def wired(port: Multiport, wiring: str) -> Multiport:
    """Port of a bimorph, of which both layers are in parallel, wired in ``series`` or as it is."""
    return in_series(port) if wiring == "series" else port


def connect(first: Multiport, second: Multiport, joints: Mapping[str, str]) -> Multiport:
    """Two multiports joined: motions equal, efforts added.

    The joints stay ports under the first one's names, free or to be loaded further.

    Parameters
    ----------
    joints : mapping of str to str
        Ports of the first with the ports of the second that move with them; with none the two
        stand side by side.

    Raises InputError if a port is unknown or joined twice, two joined ports are of different kinds,
    two others have one name, or the frequencies differ.
    """
    if not np.array_equal(first.frequencies, second.frequencies):
        raise InputError("two multiports at different frequencies cannot be joined; use the same")
    taken = [second.index(name) for name in joints.values()]
    if len(set(taken)) < len(taken):
        raise InputError("one port is joined to two of another multiport; join these first")
    for mine, theirs in joints.items():
        _check_joint(first.ports[first.index(mine)], second.ports[second.index(theirs)])
    added = second.others(joints.values())
    ports = (*first.ports, *(second.ports[second.index(name)] for name in added))
    place = {theirs: first.index(mine) for mine, theirs in joints.items()}
    place |= {name: len(first.ports) + i for i, name in enumerate(added)}
    at = np.array([place[name] for name in second.names])
    d = np.zeros((first.frequencies.size, len(ports), len(ports)), dtype=complex)
    d[:, : len(first.ports), : len(first.ports)] = first.stiffness
    d[:, at[:, None], at] += second.stiffness
    return Multiport(first.frequencies, d, ports)


def measured_between(lower: Multiport, upper: Multiport) -> Multiport:
    """Lateral actuator of two, one on the other, with the place where they meet as a port."""
    below = lower.renamed({"w_tip": MEASURED.name, "psi_tip": "psi_measured"})
    joints = {MEASURED.name: "w_base", "psi_measured": "psi_base", "voltage": "voltage"}
    return reduce(connect(below, upper, joints), [port.name for port in (*BIMORPH, MEASURED)])


def _check_joint(one: Port, other: Port) -> None:
    if one.pair != other.pair:
        described = (f'"{p.name}" ({p.pair.motion} in {p.pair.motion_unit})' for p in (one, other))
        raise InputError(
            f"ports {' and '.join(described)} are of different kinds; join ports of one kind"
        )


def reduce(port: Multiport, keep: Iterable[str]) -> Multiport:
    """Reduction to some ports, in that order; no effort acts on the others."""
    return eliminated(port, keep)[0]


def eliminated(port: Multiport, keep: Iterable[str]) -> tuple[Multiport, Complex]:
    """:func:`reduce`, and the motions (n, f, k) of the f others per motion kept."""
    keep = list(keep)
    kept, free = ([port.index(n) for n in names] for names in (keep, port.others(keep)))
    seen = port.block(*keep)
    d = port.stiffness
    if not free:
        return seen, np.zeros((d.shape[0], 0, len(kept)), dtype=complex)
    follows = _balanced_solve(d[:, free][:, :, free], -d[:, free][:, :, kept])
    return replace(seen, stiffness=seen.stiffness + d[:, kept][:, :, free] @ follows), follows


@dataclass(frozen=True)
class Response:
    """Complex peak amplitudes (SI) by port name, (n,) arrays."""

    motion: dict[str, Complex]  #: At all ports
    effort: dict[str, Complex]  #: At the driven ports; the others' is what was given


def respond(
    port: Multiport, drive: Mapping[str, Any], efforts: Mapping[str, Any] | None = None
) -> Response:
    """Response to prescribed motions (a voltage is one) and efforts.

    Parameters
    ----------
    drive : mapping of str to number or (n,) array
        Ports with their motions; 0 holds a port, and its effort is that of the holder.
    efforts : mapping of str to number or (n,) array, optional
        What acts on other ports; nothing acts on those in neither.

    Raises
    ------
    InputError
        If a port is unknown, or both moved and loaded.
    numpy.linalg.LinAlgError
        If nothing holds a port that is free.
    """
    d, n = port.stiffness, port.frequencies.size
    driven = [port.index(name) for name in drive]
    free = [port.index(name) for name in port.others(drive)]
    both = [name for name in efforts or () if port.index(name) in driven]
    if both:
        raise InputError(f'port "{both[0]}" is both moved and loaded; state one of the two')
    motion = np.zeros((n, len(port.ports)), dtype=complex)
    effort = np.zeros((n, len(driven)), dtype=complex)
    for at, value in zip(driven, drive.values(), strict=True):
        if not np.any(value):
            continue  # of a port held at 0 nothing follows
        follows = _free_motion(d, free, -d[:, free, at][..., None])
        answers = np.einsum("nij,nj->ni", d[:, driven][:, :, free], follows) + d[:, driven, at]
        weight = np.broadcast_to(value, n)
        motion[:, at] += weight
        motion[:, free] += follows * weight[:, None]
        effort += answers * weight[:, None]
    if efforts:
        right = np.zeros((n, len(free), 1), dtype=complex)
        for name, value in efforts.items():
            right[:, free.index(port.index(name)), 0] = value
        follows = _free_motion(d, free, right)
        motion[:, free] += follows
        effort += np.einsum("nij,nj->ni", d[:, driven][:, :, free], follows)
    return Response(
        dict(zip(port.names, motion.T, strict=True)), dict(zip(drive, effort.T, strict=True))
    )


def _free_motion(d: Complex, free: list[int], right: Complex) -> Complex:
    """Motion (n, f) of free ports under efforts (n, f, 1)."""
    if not free:
        return right[..., 0]
    return _balanced_solve(d[:, free][:, :, free], right)[..., 0]


def _balanced_solve(matrix: Complex, right: Complex) -> Complex:
    """Solve (n, k, k) systems for (n, k, m) after scaling rows and columns.

    Displacements (m) and rotations (rad) differ by the length of the beam; without the
    scaling the condition number is mostly a matter of units.
    """
    scale = _scale(matrix)
    scaled = matrix * scale[:, :, None] * scale[:, None, :]
    return np.asarray(np.linalg.solve(scaled, right * scale[..., None]) * scale[..., None])


def _scale(matrix: Numbers) -> Floats:
    largest = np.abs(matrix).max(axis=2)
    return np.asarray(1.0 / np.sqrt(np.where(largest > 0.0, largest, 1.0)))


def balanced(matrix: Complex) -> Complex:
    """Matrices (n, k, k) with rows and columns scaled to a largest entry of about 1."""
    scale = _scale(matrix)
    return np.asarray(matrix * scale[:, :, None] * scale[:, None, :])


def round_off(port: Multiport, driven: Iterable[str] = ("voltage",)) -> Floats:
    """Relative round-off bound (n,): machine epsilon times the condition number.

    The condition number is that of the balanced matrix which :func:`respond` solves.
    """
    free = hold(port, *driven).stiffness
    return np.asarray(np.linalg.cond(balanced(free)) * np.finfo(float).eps)


def symmetric_form(port: Multiport) -> Complex:
    """S (n, k, k), D with each row times its pair's sign: symmetric if reciprocal."""
    signs = np.array([p.pair.sign for p in port.ports])
    return np.asarray(port.stiffness * signs[:, None])


def passivity_margin(port: Multiport) -> Floats:
    """Smallest eigenvalue (n,) of the dissipation form, scaled to the largest.

    The mean power taken in is ½ Ω Im(xᴴ S x); a passive model has Im S positive semidefinite,
    so the margin is ≥ 0 up to rounding.
    """
    s = balanced(symmetric_form(port))
    eigenvalues = np.linalg.eigvalsh(0.5 * (s.imag + s.imag.transpose(0, 2, 1)))
    return np.asarray(eigenvalues[:, 0] / np.maximum(np.abs(eigenvalues).max(axis=1), 1e-300))


def reciprocity_error(port: Multiport) -> Floats:
    """Max |S − Sᵀ| (n,), each entry relative to its two diagonal neighbours."""
    s = symmetric_form(port)
    size = np.sqrt(np.abs(np.einsum("nii->ni", s)))
    scale = np.maximum(size[:, :, None] * size[:, None, :], np.abs(s))
    scale = np.where(scale > 0.0, scale, 1.0)  # where nothing couples
    return np.asarray((np.abs(s - s.transpose(0, 2, 1)) / scale).max(axis=(1, 2)))
