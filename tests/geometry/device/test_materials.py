"""Materials: full tensors that stand exactly for the reduced constants, or a refusal."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.materials import EPS0, isotropic_stiffness, orthotropic_stiffness
from tactgen.geometry.device.parameters import Piezo
from tactgen.geometry.errors import InputError

# a 6 x 6 inversion of a matrix of condition number about 10
ROUNDING = 1e-13


@pytest.mark.parametrize("name", LIBRARY)
def test_reduced_constants_are_reproduced(name):
    """The tensors give s11, s55, d31 and eps33 of the reduced set, in the device's axes."""
    ceramic = LIBRARY[name]
    tensors, reduced = ceramic.tensors(), ceramic.reduced()
    s = np.linalg.inv(tensors.c)
    d = tensors.e @ s
    eps_t = tensors.eps + d @ tensors.c @ d.T
    # length z, poling x: s_zz,zz = s11; s_xz,xz = s55; d_x,zz = d31; eps_xx = eps33
    assert s[2, 2] == pytest.approx(reduced["s11"], rel=ROUNDING)
    assert s[4, 4] == pytest.approx(reduced["s55"], rel=ROUNDING)
    assert d[0, 2] == pytest.approx(reduced["d31"], rel=ROUNDING)
    assert eps_t[0, 0] == pytest.approx(reduced["eps33"] * EPS0, rel=ROUNDING)


def test_pzt_5h_is_the_published_tensor():
    """PZT-5H in the device's axes is the published IEEE tensor, turned; nothing rescaled."""
    tensors = LIBRARY["PZT-5H"].tensors()
    c, e, eps = tensors.c / 1e9, tensors.e, tensors.eps / EPS0
    # IEEE 1 -> z, 2 -> y, 3 -> x
    for value, got in (
        (127.2, c[2, 2]), (127.2, c[1, 1]), (117.4, c[0, 0]), (80.2, c[1, 2]), (84.7, c[0, 1]),
        (84.7, c[0, 2]), (23.0, c[4, 4]), (23.0, c[5, 5]), (23.5, c[3, 3]), (23.24, e[0, 0]),
        (-6.62, e[0, 1]), (-6.62, e[0, 2]), (17.03, e[2, 4]), (17.03, e[1, 5]),
        (1433.0, eps[0, 0]), (1704.0, eps[1, 1]), (1704.0, eps[2, 2]),
    ):  # fmt: skip
        assert got == pytest.approx(value, rel=ROUNDING)
    assert np.count_nonzero(np.abs(e) > 1e-9) == 5


def test_unchanged_round_trip():
    """Replacing every reduced constant by its own value leaves the tensors unchanged."""
    for ceramic in LIBRARY.values():
        again = ceramic.with_values(**ceramic.reduced())
        for kept, was in ((again.s, ceramic.s), (again.d, ceramic.d), (again.eps_t, ceramic.eps_t)):
            np.testing.assert_allclose(kept, was, rtol=ROUNDING, atol=ROUNDING * np.abs(was).max())


@given(
    st.floats(0.8, 1.25), st.floats(0.7, 1.4), st.floats(0.5, 1.1), st.floats(1.0, 2.0),
    st.sampled_from(sorted(LIBRARY)),
)  # fmt: skip
def test_any_reduced_set_is_reproduced(s11, s55, d31, eps33, name):
    """Whatever admissible constants a user states, the full tensors give exactly these."""
    base = LIBRARY[name].reduced()
    given_set = {
        **base, "s11": base["s11"] * s11, "s55": base["s55"] * s55,
        "d31": base["d31"] * d31 * np.sqrt(s11), "eps33": base["eps33"] * eps33,
    }  # fmt: skip
    got = LIBRARY[name].with_values(**given_set).reduced()
    for key, value in given_set.items():
        assert got[key] == pytest.approx(value, rel=ROUNDING)


@given(
    st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5),
    st.floats(0.2, 5.0), st.floats(0.2, 5.0), st.sampled_from(sorted(LIBRARY)),
)  # fmt: skip
def test_tensors_are_judged_by_their_energy(d33, d15, s12, s13, d31, eps33, name):
    """Positive definite stiffness and clamped permittivity, or a refusal.

    The judge is the energy itself: the form [s, d; dᵀ, ε^T] of stress and field is positive
    definite for admissible sets and for no others.
    """
    base = LIBRARY[name]
    reduced = base.reduced()
    ceramic = base.with_values(
        **{**reduced, "d31": d31 * reduced["d31"], "eps33": eps33 * reduced["eps33"]}
    )
    s, d = ceramic.s.copy(), ceramic.d.copy()
    s[0, 1] = s[1, 0] = s12 * s[0, 1]
    s[5, 5] = 2.0 * (s[0, 0] - s[0, 1])
    for i, j in ((0, 2), (2, 0), (1, 2), (2, 1)):
        s[i, j] *= s13
    d[2, 2] *= d33
    d[0, 4], d[1, 3] = d15 * d[0, 4], d15 * d[1, 3]
    ceramic = replace(ceramic, s=s, d=d)
    energy = np.block([[ceramic.s, ceramic.d.T], [ceramic.d, ceramic.eps_t]])
    scale = 1.0 / np.sqrt(np.abs(np.diag(energy)))
    least = np.linalg.eigvalsh(energy * scale[:, None] * scale)[0]
    if abs(least) < 1e-12:  # on the border, where rounding decides
        return
    if least < 0.0:
        with pytest.raises(InputError, match="not"):
            ceramic.tensors()
        return
    tensors = ceramic.tensors()
    assert np.linalg.eigvalsh(tensors.c)[0] > 0.0
    assert np.linalg.eigvalsh(tensors.eps)[0] > 0.0


@pytest.mark.parametrize(
    ("constants", "words"),
    [
        ({"d33": 0.0}, "only d33 between"),
        ({"d31": 1.6}, "d31 alone makes the planar coupling factor 1"),
        ({"d15": 2.0}, "d15 = .* makes k15 = 1"),
        ({"s12": 4.0}, r"\|s12\| = .* is not below the root of s11 s22"),
        ({"s13": 1.7}, r"2 s13\^2 is not below s33 \(s11 \+ s12\)"),
        ({"s33": -1.0}, "s33 = .* is not positive"),
    ],
)
def test_refusal_names_what_contradicts(constants, words):
    """The sentence tells which constants clash, not only that some do."""
    ceramic = LIBRARY["M1876"]
    s, d = ceramic.s.copy(), ceramic.d.copy()
    places = {
        "s12": (s, [(0, 1), (1, 0)]), "s13": (s, [(0, 2), (2, 0), (1, 2), (2, 1)]),
        "s33": (s, [(2, 2)]), "d31": (d, [(2, 0), (2, 1)]), "d33": (d, [(2, 2)]),
        "d15": (d, [(0, 4), (1, 3)]),
    }  # fmt: skip
    for name, factor in constants.items():
        matrix, where = places[name]
        for at in where:
            matrix[at] *= factor
    with pytest.raises(InputError, match=words):
        replace(ceramic, s=s, d=d).tensors()


def test_range_of_d33_is_sharp():
    """Just inside the range that the refusal states a tensor is admissible, just outside not."""
    ceramic = LIBRARY["M1876"]
    with pytest.raises(InputError) as caught:
        replace(ceramic, d=ceramic.d * np.where(np.arange(6) == 2, 0.0, 1.0)).tensors()
    low, high = (
        float(v) for v in re.search(r"between (\S+) and (\S+) m/V", str(caught.value)).groups()
    )
    for border, inwards in ((low, 1.0), (high, -1.0)):
        d = ceramic.d.copy()
        d[2, 2] = border + inwards * 1e-3 * (high - low)  # four digits are printed
        replace(ceramic, d=d).tensors()
        d[2, 2] = border - inwards * 1e-3 * (high - low)
        with pytest.raises(InputError):
            replace(ceramic, d=d).tensors()


@pytest.mark.parametrize("name", LIBRARY)
def test_losses_dissipate(name):
    """With losses the material takes in power for every strain and field: Im[c e; e −ε] ≥ 0."""
    tensors = LIBRARY[name].tensors(lossy=True)
    form = np.block([[tensors.c, -tensors.e.T], [-tensors.e, -tensors.eps]])
    scale = 1.0 / np.sqrt(np.abs(np.diag(form)))
    values = np.linalg.eigvalsh((form * scale[:, None] * scale).imag)
    assert values[0] > 0.0
    # Q and tan δ themselves, on the unclamped constants
    s = np.linalg.inv(tensors.c)
    assert (1 / s[2, 2]).imag / (1 / s[2, 2]).real == pytest.approx(
        1 / LIBRARY[name].quality_factor, rel=ROUNDING
    )


@pytest.mark.parametrize("name", sorted(LIBRARY))
def test_no_d31_is_a_passive_ceramic(name):
    """d31 = 0 switches all piezoelectric constants off, which every material survives."""
    tensors = Piezo(material=name, d31=0.0).ceramic().tensors()
    assert not tensors.e.any()
    assert np.linalg.eigvalsh(tensors.eps).min() > 0.0


@given(st.floats(1e9, 5e11), st.floats(-0.5, 0.45))
def test_isotropic_limit_of_the_shim(young, nu):
    """Equal moduli and G = E/2(1+ν) give Lamé's stiffness."""
    lame, shear = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    expected = np.zeros((6, 6))
    expected[:3, :3] = lame
    expected[range(6), range(6)] += [2 * shear] * 3 + [shear] * 3
    # the inversion's condition number is (1 + ν)/(1 − 2ν), 15 at most
    np.testing.assert_allclose(
        isotropic_stiffness(young, nu), expected, rtol=0, atol=1e-13 * expected.max()
    )


def test_orthotropic_shim_has_its_moduli():
    """The compliance of the shim shows E along z, E across, and G in the planes with z."""
    s = np.linalg.inv(orthotropic_stiffness(140e9, 10e9, 5e9, 0.3))
    assert 1 / s[2, 2] == pytest.approx(140e9, rel=ROUNDING)
    assert 1 / s[0, 0] == pytest.approx(10e9, rel=ROUNDING)
    assert 1 / s[4, 4] == pytest.approx(5e9, rel=ROUNDING)
    assert -s[2, 0] / s[2, 2] == pytest.approx(0.3, rel=ROUNDING)


def test_impossible_shim_is_refused():
    """A transverse modulus too large for the axial one and ν is refused with the remedy."""
    with pytest.raises(InputError, match=r"shim\.transverse_modulus.*lower"):
        orthotropic_stiffness(1e9, 100e9, 5e9, 0.3)
