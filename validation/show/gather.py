"""Ask models of a scene for their fields; every number beside a picture is a quantity."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import engineering
from tactgen.tmm.ports.excitation_and_circuit import (
    Excitation,
    PortState,
    excitation_of,
    port_states,
)
from tactgen.tmm.ports.multiport import Multiport, wired
from tactgen.validation.catalogue.models import MODELS, models_of
from tactgen.validation.catalogue.quantities import (
    OPEN_CIRCUIT_FREQUENCIES,
    SHORT_CIRCUIT_FREQUENCIES,
    STATIC_TIP_DISPLACEMENT,
    TIP_DISPLACEMENT,
)
from tactgen.validation.engine.answers import NONE, modelling_at
from tactgen.validation.engine.solve import Solution, make_plan, solve
from tactgen.validation.models.bimorph.mesh_pair import TwoMeshModel
from tactgen.validation.models.bimorph.model import BeamTheoryModel, BimorphModel
from tactgen.validation.models.classes import make_model
from tactgen.validation.models.model import Quantity, Stages
from tactgen.validation.models.transient import Simulation, scene_beam
from tactgen.validation.scene.conditions import beyond_voltage, conditions, driven_in_words
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.field import Circuit, FieldResult, State
from tactgen.validation.show.generator_body import MovingBody, RowFields, moving_body
from tactgen.validation.show.solid_fields import Detail, Found, SolidFields

#: The model of the normal actuator whose field is shown.
MAGNETIC = "axisymmetric"
#: Circuits that modes are shown in.
CIRCUITS: tuple[tuple[Circuit, str], ...] = (
    ("short", SHORT_CIRCUIT_FREQUENCIES.name), ("open", OPEN_CIRCUIT_FREQUENCIES.name),
)  # fmt: skip


def default_models(scene: Scene) -> tuple[str, ...]:
    """Model to look at: the fastest solid that the scene asks for, else a row."""
    for name in ("solid", "cad", "tmm", "beam", "lumped", MAGNETIC):
        if name in scene.models:
            return (name,)
    raise InputError(
        f"models = {', '.join(scene.models)} in scene {scene.name} have neither a bimorph that "
        f'moves nor a field to show; name another scene, such as "paper", or set models={MAGNETIC}'
    )


def gather(
    scene: Scene,
    models: Sequence[str],
    frequencies: tuple[float, ...] | None = None,
    detail: Detail = "nodes",
    announce: Callable[[str], None] = lambda _: None,
) -> list[FieldResult]:
    """Fields of a scene by each of the models, in their order.

    Parameters
    ----------
    frequencies : tuple of float, optional
        Of harmonic states (Hz); None takes half the first frequency of bending and that itself.
    detail : {"nodes", "edges"}
        Every node of bricks, or those that a picture needs.

    Raises InputError if a model has no field in space, or both actuators are asked for at once.
    """
    able = (*models_of("bimorph"), MAGNETIC)
    for name in models:
        if name not in able:
            raise InputError(
                f"the model {name} has no motion or field to show; models that have are "
                f"{', '.join(able)}"
            )
    if MAGNETIC in models:
        if set(models) != {MAGNETIC}:
            raise InputError(
                f"the model {MAGNETIC} shows the normal actuator and {models[0]} the lateral one; "
                "ask for them one after the other"
            )
        from tactgen.validation.show.magnetic import gather_magnetic

        return [gather_magnetic(scene, announce, opened=detail == "edges")]
    solution = solve(scene, tuple(models), [name for _, name in CIRCUITS], announce)
    return [gather_from(solution, name, frequencies, detail, announce) for name in models]


def gather_from(
    solution: Solution,
    name: str,
    frequencies: tuple[float, ...] | None = None,
    detail: Detail = "nodes",
    announce: Callable[[str], None] = lambda _: None,
) -> FieldResult:
    """Fields of one model of a solution that has its natural frequencies: see :func:`gather`.

    The models of the solution are asked, so that nothing is solved twice.
    """
    model, scene = solution.models[name], solution.scene
    assert isinstance(model, BimorphModel)
    announce(f"fields of {name}")
    fields: SolidFields | RowFields
    if isinstance(model, TwoMeshModel):
        fields = SolidFields(model, detail)
    else:
        assert isinstance(model, BeamTheoryModel)
        fields = RowFields(model)
    states = _modes(solution, name, fields)
    if frequencies is None:
        bending = (s for s in states if s.motion == "bending_x" and s.circuit == "short")
        first = next((s.frequency for s in bending), None)
        frequencies = () if first is None else (0.5 * first, first)
    announce(f"motion of {name} at rest and at {len(frequencies)} frequencies")
    for state, modelling in _port_states(solution, name, frequencies):
        announce(f"fields of {name} at {state.frequency:.5g} Hz")
        states.append(_driven(state, fields.driven(state), modelling))
    return FieldResult(
        scene.name, name, fields.mesh, tuple(states), *_drive(scene), MODELS[name].theory,
        conditions=conditions(scene), place=scene.measurement.place,
    )  # fmt: skip


def _drive(scene: Scene) -> tuple[str, str]:
    """What drives, and what does at rest, in words: a voltage alone by its amplitude."""
    if not beyond_voltage(scene):
        volts = f"at {engineering(scene.drive.voltage, 'V', 3)}"
        return f"{volts} peak", volts
    still = scene.drive.model_copy(update={"base_acceleration": 0.0})
    return driven_in_words(scene.drive, scene.circuit), driven_in_words(still, scene.circuit)


def _port_states(
    solution: Solution, name: str, frequencies: Sequence[float]
) -> list[tuple[PortState, str]]:
    """States at rest, if something acts there that the support bears, and at frequencies (Hz).

    Each with the modelling error of the tip's motion in words.
    """
    scene = solution.scene
    excitation = excitation_of(scene.circuit, scene.drive)
    acts = excitation.source or excitation.force
    still = [STATIC_TIP_DISPLACEMENT.name] if acts and not scene.ends.rigid_motions else []
    rows = [*still, *([TIP_DISPLACEMENT.name] if frequencies else [])]
    if not rows:
        return []
    asked = scene.model_copy(update={"frequency": tuple(frequencies) or scene.frequency})
    words, states = [""] * (len(still) + len(frequencies)), []
    try:
        found = solve(asked, (name,), rows, reuse=solution)
        model = found.models[name]
        words = [
            modelling_at(q, place).removeprefix(NONE)
            for q in found.quantities for place in np.ndindex(q.value.shape)
        ]  # fmt: skip
    except InputError:  # a finger beyond its range is drawn with its law's end
        model = make_model(name, asked, Stages(make_plan(asked, (name,), rows).keys))
    assert isinstance(model, BimorphModel)
    if still:
        states += _states(asked, model.static().fine, asked.ends.lossless, excitation.at_rest)
    if frequencies:
        states += _states(asked, model.ports().fine, asked.ends, excitation)
    return list(zip(states, words, strict=True))


def _states(scene: Scene, port: Multiport, ends: Ends, excitation: Excitation) -> list[PortState]:
    """States with the voltage across each layer."""
    wiring, of_layer = scene.bimorph.wiring, np.ones(5)
    of_layer[4] = 0.5 if wiring == "series" else 1.0
    found = port_states(wired(port, wiring), ends, excitation)
    return [state._replace(ports=of_layer * state.ports) for state in found]


def _modes(solution: Solution, name: str, fields: SolidFields | RowFields) -> list[State]:
    by_circuit = {c: solution.get(quantity, name) for c, quantity in CIRCUITS}
    states: list[State] = []
    for circuit, quantity in by_circuit.items():
        count = quantity.value.size
        found = fields.modes(count, open_circuit=circuit == "open")
        assert quantity.classes is not None
        for number, (values, tip, charge) in enumerate(found):
            states.append(
                State(
                    name=f"mode {number + 1}, {circuit} circuit",
                    kind="mode",
                    circuit=circuit,
                    frequency=float(quantity.value[number]),
                    error=float(quantity.error[number]),
                    fields=values,
                    tip=tip,
                    charge=charge,
                    motion=quantity.classes[number],
                    modelling=modelling_at(quantity, number).removeprefix(NONE),
                    coupling=_coupling(by_circuit, circuit, number),
                )
            )
    return states


def _coupling(by_circuit: dict[Circuit, Quantity], circuit: Circuit, number: int) -> float:
    """√(1 − (f_short / f_open)²) of a bending mode in x and its partner; nan of others."""
    this, other = by_circuit[circuit], by_circuit["open" if circuit == "short" else "short"]
    assert this.classes is not None
    assert other.classes is not None
    if this.classes[number] != "bending_x":
        return float("nan")
    place = this.classes[:number].count("bending_x")
    partners = np.flatnonzero(np.array(other.classes) == "bending_x")
    if place >= partners.size:
        return float("nan")
    low, high = sorted((float(this.value[number]), float(other.value[partners[place]])))
    return float(np.sqrt(1.0 - (low / high) ** 2))


def _driven(state: PortState, found: Found, modelling: str) -> State:
    """Driven state; at rest all is real."""
    values, tip, charge = found
    name, kind = f"{state.frequency:.5g} Hz", "harmonic"
    if not state.frequency:
        name = kind = "static"
        values = {name: np.real(of) for name, of in values.items()}
        tip, charge = tip.real, charge.real
    return State(
        name=name,
        kind="static" if kind == "static" else "harmonic",
        circuit="driven",
        frequency=state.frequency,
        error=float("nan"),
        fields=values,
        tip=tip,
        charge=charge,
        modelling=modelling,
    )


def body_of(found: Simulation) -> MovingBody:
    """Moving body of a run."""
    device, beam = scene_beam(found.scene)
    return moving_body(device, beam, found.machine.modes)
