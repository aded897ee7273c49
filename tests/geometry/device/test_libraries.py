"""Shims and steels by name: a second transcription of every number, and what must hold of them."""

import numpy as np
import pytest
from pydantic import ValidationError

from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.material_library import SHIMS, SOFT_MAGNETS, STEELS
from tactgen.geometry.device.parameters import Piezo, Shim, Steel, sources, spreads
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.errors import InputError
from tactgen.validation.scene.load import load_scene

#: E (GPa), Poisson ratio, density (g/cm³), range of E, and what the source is of.
SHEETS = {
    "brass": (110, 0.34, 8.53, (103, 117), "C26000"),
    "stainless steel": (193, 0.29, 8.00, (190, 200), "301 and 304"),
    "spring steel": (206, 0.29, 7.85, (200, 212), "C75S"),
    "titanium": (114, 0.34, 4.43, (105, 120), "Ti-6Al-4V"),
    "nickel silver": (125, 0.33, 8.70, (120, 130), "C77000"),
    "phosphor bronze": (110, 0.34, 8.86, (103, 117), "C51000"),
    "aluminium": (70, 0.33, 2.70, (68, 73), "5052 to 7075"),
    "AS4 CFRP": (147, 0.27, 1.60, (135, 150), "AS4/3501-6"),
}

#: Terms of the ESRF's fits as tables of Radia print them: [k, µ0 Ms in T] three times.
RADIA = {
    "armco": "[4236., 1.385], [126.2, 0.2649], [34., 0.5]",
    "xc06": "[2118, 1.362], [63.06, 0.2605], [17.138, 0.4917]",
    "steel37": "[1596.3, 1.1488], [133.11, 0.4268], [18.713, 0.4759]",
    "steel42": "[968.66, 1.441], [24.65, 0.2912], [8.3, 0.3316]",
    "afk1": "[2001., 1.704], [38.56, 0.493], [1.24, 0.152]",
    "afk502": "[10485., 1.788], [241.5, 0.437], [7.43, 0.115]",
}


@pytest.mark.parametrize("name", SHIMS)
def test_shims_are_the_printed_ones(name):
    """Constants, ranges around them, and a stiffness that stores energy."""
    modulus, poisson, density, (low, high), words = SHEETS[name]
    shim = Shim(material=name)
    assert (shim.youngs_modulus, shim.poisson_ratio) == (modulus * 1e9, poisson)
    assert shim.density == pytest.approx(density * 1e3, rel=1e-15)
    assert words in sources(shim)["youngs_modulus"]
    found = spreads(shim)
    assert found["youngs_modulus"][:2] == (low * 1e9, high * 1e9)
    for key, spread in found.items():
        assert spread.low <= getattr(shim, key) <= spread.high
    assert np.linalg.eigvalsh(shim.stiffness()).min() > 0.0
    if SHIMS[name].shear_modulus is None:
        assert shim.modulus_across == pytest.approx(shim.youngs_modulus, rel=1e-15)


def test_a_metal_stays_isotropic_with_another_modulus():
    """The shear modulus follows what is stated, unless it is stated itself."""
    shim = Shim(material="Brass", youngs_modulus="100 GPa", poisson_ratio=0.25)
    assert shim.shear_modulus == pytest.approx(40e9, rel=1e-15)
    assert Shim(material="brass", shear_modulus="38 GPa").shear_modulus == 38e9
    assert spreads(shim)["youngs_modulus"].whose == "assumed"
    assert Shim(material="carbon fibre") == Shim()


@pytest.mark.parametrize(
    ("group", "name", "meant"),
    [
        (Shim, "Stainless_Steel", "stainless steel"), (Shim, "Ti6Al4V", "titanium"),
        (Piezo, "pz 27", "Pz27"), (Piezo, "Navy Type VI", "PZT-5H"), (Piezo, "navy-II", "PZT-5A"),
    ],
)  # fmt: skip
def test_materials_go_by_folded_names_and_navy_types(group, name, meant):
    """Case, hyphens and spaces do not matter; the Navy's types are translated as makers do."""
    assert group(material=name) == group(material=meant)


@pytest.mark.parametrize(
    ("group", "name", "words"),
    [
        (Shim, "bras", 'did you mean "brass"'),
        (Shim, 3, "is not in the library"),
        (Piezo, ["a"], "is not in the library"),
        (Piezo, "PZT5K", 'did you mean "PZT-5'),
    ],
)
def test_unknown_names_get_the_nearest(group, name, words):
    """With the list of those that are known."""
    with pytest.raises(ValidationError, match=words):
        group(material=name)


@pytest.mark.parametrize("name", RADIA)
def test_steels_are_the_fitted_ones(name):
    """B − µ0 H is the sum of the printed terms, at fields between the table's points, too.

    Within 1e-3 of B: what the cubic through 80 points leaves of terms of very different scales.
    """
    terms = np.array(eval(f"[{RADIA[name]}]"))
    curve = magnetisation_curve(Steel(curve=name))
    applied = np.geomspace(1e-6, 5.0, 300)  # µ0 H, T
    slopes, limits = terms.T[:, :, None]
    b = applied + (limits * np.tanh(applied * slopes / limits)).sum(axis=0)
    assert curve.flux_density_at(applied / MU0) == pytest.approx(b, rel=1e-3)


@pytest.mark.parametrize("name", SOFT_MAGNETS)
def test_steels_rise_and_saturate(name):
    """H(B) rises everywhere; the last point's permeability is vacuum's, as beyond it."""
    curve = magnetisation_curve(Steel(curve=name))
    assert np.diff(curve.field_strength(np.linspace(0.0, 6.0, 4000))).min() > 0.0
    assert curve.slope(curve.flux_density[-1:]) * MU0 == pytest.approx(1.0, rel=1e-4)
    assert not curve.ends_early
    # iron's 2.15 T is the most that carbon steels have; cobalt takes it to 2.4 T
    assert 1.9 < SOFT_MAGNETS[name].saturation < 2.4


def test_steels_go_by_folded_names_or_are_files():
    """A scene's curve is spelt as the library spells it; a misspelt one gets the nearest."""
    assert Steel(curve="Pure-Iron").curve == "armco"
    assert load_scene("reluctance", ["steel.curve=AISI 1010"])[0].steel.curve == "steel37"
    assert set(SOFT_MAGNETS) < set(STEELS)
    with pytest.raises(InputError, match='did you mean "armco"'):
        magnetisation_curve(Steel(curve="armko"))
