"""What heavy rows ask and make of the answers, on answers that are made up of what was asked.

The answers themselves take seconds to minutes; by default only some of them are asked for.
"""

import zlib
from types import SimpleNamespace

import numpy as np
import pytest
from approved import described

from tactgen.tmm.reluctance.coenergy.map import Samples
from tactgen.validation.checks import amplitude_measurements as amplitude
from tactgen.validation.checks import bimorph_measurements as bimorph
from tactgen.validation.checks import reluctance_measurements as reluctance
from tactgen.validation.checks import team20
from tactgen.validation.checks.amplitude import AMPLITUDE_CHECKS
from tactgen.validation.checks.bimorph import CHECKS
from tactgen.validation.checks.cases.magnetics import team20 as problem
from tactgen.validation.checks.reluctance import MAGNETIC_CHECKS
from tactgen.validation.checks.row import value_of
from tactgen.validation.checks.team20 import TEAM20_CHECKS
from tactgen.validation.engine.results import Measured


def made_of(*asked, count=None):
    """Return one number or several between 1 and 2 that are others for whatever else is asked."""
    chance = np.random.default_rng(zlib.crc32(repr(asked).encode()))
    return chance.uniform(1.0, 2.0, count)


def in_words(measured):
    """Return a measured value, with its bar where it has one."""
    value = value_of(measured)
    bar = f" ± {measured.bar:.3g}" if isinstance(measured, Measured) else ""
    return "rounding" if abs(value) < 1e-8 else f"{value:.7g}{bar}"


@pytest.fixture
def asked(monkeypatch, approved):
    """Return a list for what is asked, and what measures rows and has all of it approved."""
    found = []

    def measured(rows, *cached):
        for function in cached:
            function.cache_clear()
        told = {row.id: in_words(row.measure()) for row in rows}
        for function in cached:
            function.cache_clear()
        approved(described([told, *dict.fromkeys(map(str, found))]))

    return found, measured


def picked(rows, *names):
    return [row for row in rows if row.id.startswith(names)]


def test_job_j1(asked, monkeypatch):
    """Levels of its mesh, and which of its numbers."""
    asked, measured = asked

    def solved(name, models, quantities, *overrides):
        asked.append((name, models, quantities, overrides))

        def get(quantity, model):
            count = 9 if "frequencies" in quantity else None
            value = made_of(name, model, quantity, overrides, count=count)
            return SimpleNamespace(value=value, uncertainty=0.1 * value, classes=None)

        return SimpleNamespace(get=get)

    monkeypatch.setattr(bimorph, "_solved", solved)
    measured(picked(CHECKS, "SOL-", "X-12"))


def test_fields_and_networks_of_the_normal_actuator(asked, monkeypatch):
    """Forces by the laws of a made-up gap, which know at which order and grid they are asked."""
    asked, measured = asked

    def point(device, current=None, gap=None, **how):
        current = device.coil.current if current is None else current
        gap = device.gap if gap is None else gap
        asked.append((device.steel, f"{current:.6g} {gap:.6g}", how))
        force = (1.0 + 0.1 * made_of(how, device.steel)) * current**2 / (gap + 0.1e-3) ** 2
        linkage = 2.0 * current / (gap + 0.1e-3)
        return SimpleNamespace(
            force=force, force_eggshell=1.01 * force, flux_linkage=linkage,
            coenergy=current**2 / (gap + 0.1e-3),
            errors=SimpleNamespace(force=0.03 * force, flux_linkage=0.02 * linkage),
        )  # fmt: skip

    def network(device, currents, gaps, *_):
        asked.append((device.steel, currents.shape, gaps.shape))
        i, g = np.meshgrid(currents, gaps + 0.11e-3, indexing="ij")
        return Samples(currents, gaps, 2.0 * i / g * (1.0 + i * g), i**2 / g**2)

    monkeypatch.setattr(reluctance, "field_point", point)
    monkeypatch.setattr(reluctance, "network_samples", network)
    monkeypatch.setattr(reluctance, "solve_map", lambda device, gaps, currents, **how: [
        [point(device, current, gap, **how) for current in currents] for gap in gaps])  # fmt: skip
    monkeypatch.setattr(reluctance, "load_scene", lambda name, overrides: (
        SimpleNamespace(pull=(name, *overrides)), {}))  # fmt: skip
    monkeypatch.setattr(reluctance, "rod_of", lambda scene, pull: SimpleNamespace(
        stiffness=made_of(pull, count=(3, 3)), motional=-made_of(pull, 1),
        inductance=made_of(pull, 2),
    ))  # fmt: skip
    rows = picked(MAGNETIC_CHECKS, "LOOP-", "NET-", "FORCE-", "HOLD")
    measured(rows, reluctance._network, reluctance._rod)


def test_rocking_heads(asked, monkeypatch):
    """Which head in which state under which load, driven how far, over which band."""
    asked, measured = asked

    def head(scene):
        asked.append(scene)
        return SimpleNamespace(oscillator=scene)

    def branch(of, *how):
        asked.append((of.oscillator, how))
        return of.oscillator, how

    def special(oscillator, at, *more):
        found = sorted(made_of(oscillator, at, len(more), count=2))
        return [SimpleNamespace(orbit=SimpleNamespace(frequency=f)) for f in found]

    def loaded(of, *how):
        asked.append((of.oscillator, how))
        return SimpleNamespace(
            displacement=1j * made_of(of.oscillator, how, count=5),
            fitted_slope=made_of(of.oscillator, how),
        )

    monkeypatch.setattr(amplitude, "load_scene", lambda *given: (given, {}))
    monkeypatch.setattr(amplitude, "held_head", head)
    monkeypatch.setattr(amplitude, "response_branch", branch)
    monkeypatch.setattr(amplitude, "folds", special)
    monkeypatch.setattr(amplitude, "peaks", special)
    monkeypatch.setattr(amplitude, "speed", lambda of: "speed")
    monkeypatch.setattr(amplitude, "loaded_deflection", loaded)
    monkeypatch.setattr(amplitude, "voltage_for", lambda of, *how: made_of(of.oscillator, how))
    kept = amplitude._head, amplitude._prototype, amplitude._free, amplitude._loaded
    measured([row for row in AMPLITUDE_CHECKS if row.heavy], *kept)


def test_team_problem_20(asked, monkeypatch):
    """Both potentials at the measured currents; flux densities where they were measured."""
    asked, measured = asked

    class Field:
        def __init__(self, current):
            self.current = current

        def flux_density_at(self, points):
            asked.append(described(np.asarray(points)))
            return self.current * np.sin(
                1e3 * (points @ np.array([[1, 2, 3], [3, 2, 1], [1, 1, 2]]))
            )

    def states(potential, scale, currents):
        asked.append((potential.__name__, scale, currents))
        for current in currents:
            force = made_of(potential.__name__, current)
            yield SimpleNamespace(current=current, force=force), Field(current)

    monkeypatch.setattr(team20, "pole_states", states)
    monkeypatch.setattr(team20, "flux_densities", problem.flux_densities)
    measured(TEAM20_CHECKS, team20._states)
