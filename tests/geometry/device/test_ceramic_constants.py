"""Constants as data sheets print them: in any form and any number, or a refusal that names one."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.device import ceramic_constants
from tactgen.geometry.device.ceramic_constants import Forms, completed, read_constants
from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Piezo
from tactgen.geometry.errors import InputError
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.warnings import scene_warnings

# Newton's method to the last digits of tensors whose inversion loses three
ROUNDING = 1e-9

ELASTIC, PIEZO = ("11", "12", "13", "33", "55"), ("31", "33", "15")
#: Complete sets: names by the form of each of the three kinds.
SETS = {
    "strain": [*(f"s{i}" for i in ELASTIC), *(f"d{i}" for i in PIEZO), "eps11", "eps33"],
    "stress": [*(f"c{i}" for i in ELASTIC), *(f"e{i}" for i in PIEZO), "eps11S", "eps33S"],
    "at constant displacement": [
        *(f"s{i}D" for i in ELASTIC), *(f"g{i}" for i in PIEZO), "eps11", "eps33"
    ],
    "moduli and factors": [
        "Y11", "nu12", "nu13", "Y33", "c44", "d31", "k33", "k15", "eps11", "eps33S"
    ],
    "thickness": ["s11", "s12", "c13", "c33D", "c55", "kp", "kt", "d15", "eps11S", "eps33"],
}  # fmt: skip


def forms(ceramic):
    return Forms(ceramic.s, ceramic.d, ceramic.eps_t)


def constant(of, name):
    """Return one constant by its name, in SI units, permittivities relative."""
    letter = name.rstrip("DS0123456789")
    if name == "kp":
        return abs(of.d[2, 0]) * np.sqrt(2.0 / ((of.s[0, 0] + of.s[0, 1]) * of.eps_t[2, 2]))
    if name == "kt":
        return np.sqrt(1.0 - of.c[2, 2] / of.c_d[2, 2])
    i, j = (int(digit) - 1 for digit in name.removeprefix(letter)[:2])
    match letter:
        case "eps":
            return (of.eps_s if name.endswith("S") else of.eps_t)[i, j] / EPS0
        case "Y":
            return 1.0 / of.s[i, i]
        case "nu":
            return -of.s[0, j] / of.s[0, 0]
        case "k":
            return abs(of.d[i, j]) / np.sqrt(of.s[j, j] * of.eps_t[i, i])
    return getattr(of, letter + ("_d" if name.endswith("D") else ""))[i, j]


def printed(ceramic, names, digits=16):
    """Return the constants of a ceramic as text."""
    units = {"s": "m^2/N", "c": "Pa", "d": "m/V", "e": "C/m^2", "g": "V*m/N", "Y": "Pa"}
    values = {name: f"{constant(forms(ceramic), name):.{digits}g}" for name in names}
    return "; ".join(
        f"{n} {v} {units.get(n.rstrip('DS0123456789'), '')}".strip() for n, v in values.items()
    )


def assert_same(ceramic, other, rel=ROUNDING):
    """Assert that two materials have the same tensors."""
    for own, its in ((ceramic.s, other.s), (ceramic.d, other.d), (ceramic.eps_t, other.eps_t)):
        np.testing.assert_allclose(own, its, rtol=rel, atol=rel * np.abs(its).max())


@pytest.mark.parametrize("form", SETS)
@pytest.mark.parametrize("name", ["PZT-5H", "PZT-8", "APC 850"])
def test_a_complete_set_gives_the_material(name, form):
    """Ten independent constants of any form are the material, whatever stands for the rest."""
    text = printed(LIBRARY[name], SETS[form])
    if "kp" in text:  # a size, from which d31 comes with the base's sign
        assert LIBRARY["M1876"].d[2, 0] < 0.0 > LIBRARY[name].d[2, 0]
    assert_same(completed(LIBRARY["M1876"], read_constants(text)), LIBRARY[name])


def test_a_drawn_polymer_is_not_a_ceramic():
    """Constants of both directions across (class mm2) are taken one by one."""
    names = [*(f"s{i}" for i in (*ELASTIC, "22", "23", "44", "66")), *(f"d{i}" for i in PIEZO)]
    names += ["d32", "eps11", "eps22", "eps33"]
    film = LIBRARY["PVDF"]
    assert_same(completed(LIBRARY["PZT-5A"], read_constants(printed(film, names))), film)


def test_constants_of_strips_and_films():
    """As Erturk and Inman (2009) print PZT-5A to three digits; of a film by its stiffness."""
    pzt = LIBRARY["PZT-5A"]
    of = completed(pzt, read_constants(f"e31bar -10.4 C/m^2; eps33bar {13.3e-9 / EPS0}"))
    assert of.d[2, 0] == pytest.approx(pzt.d[2, 0], rel=5e-3)
    assert of.eps_t[2, 2] == pytest.approx(pzt.eps_t[2, 2], rel=5e-3)
    for film in (pzt, LIBRARY["PVDF"]):
        # stress per field of a film that is held in its plane
        stress = np.linalg.solve(film.s[:2, :2], film.d[2, :2])
        held = film.eps_t[2, 2] - film.d[2, :2] @ stress
        weaker = replace(film, d=0.9 * film.d, eps_t=0.8 * film.eps_t)
        of = completed(weaker, read_constants(f"e31f {stress[0]} C/m^2; eps33f {held} F/m"))
        assert of.d[2, :2] == pytest.approx(film.d[2, :2], rel=ROUNDING)
        assert of.eps_t[2, 2] == pytest.approx(film.eps_t[2, 2], rel=ROUNDING)


def test_the_rest_keeps_its_ratio():
    """What is not stated keeps its ratio, and d31 its value, as when single values are replaced."""
    base = LIBRARY["PZT-5A"]
    ours = completed(base, read_constants("Y11 50 GPa; eps33 2000"))
    reduced = base.reduced()
    plain = base.with_values(
        **{**reduced, "s11": 2e-11, "s55": 2e-11 / 16.4e-12 * reduced["s55"], "eps33": 2000.0}
    )
    assert_same(ours, plain)


def test_two_of_one_kind_move_a_third():
    """d31 with k31 says the permittivity or the compliance, neither of which was stated."""
    ours = forms(completed(LIBRARY["PZT-5A"], read_constants("d31 -200 pC/N; k31 0.36")))
    assert ours.d[2, 0] == pytest.approx(-200e-12, rel=ROUNDING)
    k31 = 200e-12 / np.sqrt(ours.s[0, 0] * ours.eps_t[2, 2])
    assert k31 == pytest.approx(0.36, rel=ROUNDING)


def test_a_whole_table_is_taken():
    """Both forms of one material, rounded to three digits: no digit decides, all are near."""
    pz27 = LIBRARY["Pz27"]
    text = printed(pz27, SETS["strain"], 3) + "; " + printed(pz27, SETS["stress"], 3)
    assert_same(completed(LIBRARY["PZT-5A"], read_constants(text)), pz27, 0.02)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (  # a digit off
            printed(LIBRARY["Pz27"], SETS["strain"]) + "; k33 0.50",
            "has k33 0.5, where the others give 0.6989; leave one of them out",
        ),
        ("d33 374 pF", "which is not a piezoelectric constant"),
        ("tand 0.02", r'did you mean "piezo\.loss_tangent"'),
        ("E33 61 GPa", r'not a known constant \(did you mean'),
        ("k31 1.2", "must be less than 1"),
        ("d33 1 pC/N; d33 2 pC/N", "states d33 twice"),
        ("d33", "not a name and a value; write for example"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused(text, words):
    """One sentence names the key, the constant and the remedy."""
    with pytest.raises(InputError, match=f"piezo.constants.*{words}"):
        load_scene("j1", [f"piezo.constants={text}"])


def test_names_as_data_sheets_have_them():
    """Superscripts before or after the indices, capitals, and KT."""
    one = read_constants(
        "sE11 16 m^2/N; YE33 54 GPa; epsS11 900; KT 1900; D31 -175 pC/N; cD33 1 GPa"
    )
    assert [c.name for c in one] == ["s11", "Y33", "eps11S", "eps33", "d31", "c33D"]


def test_a_scene_states_and_replaces():
    """The reduced values of a scene follow its constants, and single keys replace them."""
    text = printed(LIBRARY["PZT-5H"], SETS["stress"])
    scene, _ = load_scene("j1", [f"piezo.constants={text}", "piezo.d31=-200 pC/N"])
    assert scene.piezo.s11 == pytest.approx(LIBRARY["PZT-5H"].s[0, 0], rel=ROUNDING)
    assert scene.piezo.d31 == -200e-12
    again = Piezo(**scene.piezo.model_dump(mode="json"))
    assert again == scene.piezo


def test_a_constant_stated_twice_is_said():
    """If the two differ by more than rounding, under whatever name."""
    for constants, keys, words in (
        ("d31 -175 pC/N; eps33 1700", ["piezo.d31=-200 pC/N", "piezo.eps33=1705"],
         "d31 -175 pC/N, and with piezo.d31 and piezo.eps33 it is d31 -200 pC/N; leave one out"),
        ("eps33S 1100", ["piezo.eps33=1700"], "eps33S 1100, and with piezo.eps33 it is eps33S 8"),
    ):  # fmt: skip
        stated = ["piezo.material=PZT-5A", f"piezo.constants={constants}", *keys]
        (said,) = (text for text in scene_warnings(*load_scene("j1", stated)) if "leave" in text)
        assert said.startswith(f"piezo.constants has {words}")


def test_what_a_model_does_not_read_does_not_refuse():
    """A film of which only d31, s11 and permittivity are known is a beam, but no solid yet."""
    film = ["piezo.d31=22 pC/N", "piezo.eps33=12", "piezo.s11=4e-10 m^2/N"]
    scene, _ = load_scene("j1", [*film, "models=tmm"])
    assert scene.piezo.d31 == 22e-12
    with pytest.raises(InputError, match=r"negative energy.*piezo\.constants"):
        load_scene("j1", [*film, "models=solid"])
    load_scene("j1", [*film, "piezo.constants=d33 -30 pC/N; d15 0 pC/N", "models=solid"])
    with pytest.raises(InputError, match=r"k31 = 2.15 must be below 1"):
        load_scene("j1", ["piezo.d31=90 pC/N", "piezo.eps33=12", "models=tmm"])


def test_every_constant_reads_back_as_it_is_shown():
    for kind in ceramic_constants._KINDS.values():
        assert kind.unit.parse(kind.unit.show(0.25)) == pytest.approx(0.25, rel=1e-12)
