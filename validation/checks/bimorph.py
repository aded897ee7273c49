"""The checks of the lateral actuator as declarative rows; see :mod:`validation.checks.row`."""

from __future__ import annotations

from functools import partial

from tactgen.validation.checks import bimorph_measurements as m
from tactgen.validation.checks.pad import PAD_CHECKS
from tactgen.validation.checks.row import Check

#: Quantities of the steps from beam to solid, with the numbers of their rows X.
_BRIDGED = {
    "static_tip_displacement": ("static deflection", 3, 6),
    "short_circuit_frequencies": ("first frequency on a clamp", 4, 7),
    "capacitance_free": ("free capacitance", 5, 8),
    "open_circuit_frequencies": ("first frequency at open circuit", 13, 16),
    "coupling_factor": ("coupling factor", 14, 17),
    "capacitance_blocked": ("blocked capacitance", 15, 18),
}

_EXACT = "60-digit solution of the beam's differential equations"
_FOUR_CODES = "consensus of four public finite element codes on identical meshes"
_J1_BAR = "the error wanted of this mesh level, plus the reference's own 3e-5"
_PRINT = "two printed digits, read off a figure by the authors"

CHECKS: tuple[Check, ...] = (
    Check(
        "TMM-1", "code verification",
        "The free 14 mm prototype at 1 V peaks at the frequency of the exact beam.",
        781.609168022148, "Hz", _EXACT, 1e-9, "the peak is located to 1e-9",
        m.prototype_peak_frequency, scene="prototype",
    ),
    Check(
        "TMM-2", "code verification",
        "Its tip velocity at the peak is that of the exact beam.",
        0.0227950498840855, "m/s", _EXACT, 1e-9, "flat maximum, rounding only",
        m.prototype_peak_velocity, scene="prototype",
    ),
    Check(
        "TMM-3", "code verification",
        "The clamped 20 mm bimorph's first short-circuit frequency is exact.",
        1044.1572903341285, "Hz", _EXACT, 1e-11, "rounding", m.clamped_short_circuit,
    ),
    Check(
        "TMM-4", "code verification",
        "The same at open circuit.",
        1097.2592983544860893, "Hz", _EXACT, 1e-11, "rounding", m.clamped_open_circuit,
    ),
    Check(
        "TMM-5", "code verification",
        "The clamped bimorph's static tip displacement per volt is -K l^2/(2 EI).",
        9.9110249742097564e-7, "m/V", "closed form", 1e-12, "rounding", m.clamped_static,
    ),
    Check(
        "FIN-1", "code verification",
        "The finger's fitted stiffness has its maximum where eqs 1-5 put it.",
        735.6, "N/m", "paper eqs 1-5, table 1", 1e-4, "four digits of the reference",
        m.finger_stiffness_maximum,
    ),
    Check(
        "FIN-2", "code verification",
        "The finger's fitted damping has its minimum where eqs 1-5 put it.",
        0.486, "N s/m", "paper eqs 1-5, table 1", 1e-3, "three digits of the reference",
        m.finger_damping_minimum,
    ),
    Check(
        "BEA-1", "code verification",
        "Beam elements converge to the transfer-matrix model in their first frequency.",
        1044.1572903341285, "Hz", _EXACT, 1e-8, "20 elements of order five",
        m.beam_first_frequency,
    ),
    Check(
        "SOL-1", "code verification",
        "The solid's static tip deflection on job J1 (default mesh).",
        -6.7582e-7, "m/V", _FOUR_CODES, 1e-3, _J1_BAR, m.j1_default_deflection, scene="j1",
    ),
    Check(
        "SOL-2", "code verification",
        "The solid's first short-circuit frequency on job J1 (default mesh).",
        1065.96, "Hz", _FOUR_CODES, 1e-3, _J1_BAR, m.j1_default_first_frequency, scene="j1",
    ),
    Check(
        "SOL-3", "code verification",
        "The solid's static tip deflection on job J1 (fine mesh).",
        -6.7582e-7, "m/V", _FOUR_CODES, 2e-4, "the accuracy claimed for the fine mesh",
        m.j1_fine_deflection, scene="j1", heavy=True,
    ),
    *(
        Check(
            f"SOL-{4 + i}", "code verification",
            f"The solid's short-circuit frequency number {i + 1} on job J1 (fine mesh).",
            reference, "Hz", _FOUR_CODES, 2e-4, "the accuracy claimed for the fine mesh",
            partial(m.j1_fine_frequency, i), scene="j1", heavy=True,
        )
        for i, reference in enumerate((1065.96, 3329.10, 6642.85, 16267.0))
    ),
    Check(
        "X-1", "cross-model",
        "Lumped and transfer-matrix statics of the paper's bimorph are equal.",
        1.0, "1", "same theory", 1e-12, "rounding", m.lumped_over_tmm_static,
    ),
    Check(
        "X-2", "cross-model",
        "The lumped model's first frequency is close to the exact beam's.",
        1.0, "1", "model form: static shapes for the inertia", 0.01,
        "one element with consistent mass overestimates f1 by 0.5 % on a clamp",
        m.lumped_over_tmm_frequency,
    ),
    *(
        Check(
            f"X-{alike}", "cross-model",
            f"A solid that assumes what a beam assumes gives TMM's {name}, the shear factor being "
            "that of the section's shear energy.",
            1.0, "1", "same theory but for the ends", 1e-3, "the ends' zones", partial(
                m.beam_like_solid_over_tmm, quantity
            ),
        )
        for quantity, (name, alike, _) in _BRIDGED.items()
    ),
    *(
        Check(
            f"X-{varies}", "cross-model",
            f"A field that varies through the layers changes the {name} as the closed form says.",
            1.0, "1", "closed form: layers stiffened by 1/(1 - k31^2)", 2e-4,
            "the ends' zones, some hundredths of a step of 1.6 %", partial(
                m.field_variation, quantity
            ),
        )
        for quantity, (name, _, varies) in _BRIDGED.items()
    ),
    Check(
        "X-12", "cross-model",
        "On job J1 bricks and the tetrahedra of the CAD solids differ by no more than their error "
        "bars: deflection, capacitances, coupling factor and four frequencies.",
        (0.0, 1.0), "bars", "the same equations, neither mesh nor assembly in common", 0.0,
        "the largest difference over the sum of the two bars", m.j1_cad_against_bricks, heavy=True,
    ),
    Check(
        "PAP-1", "validation",
        "The finger's stiffness maximum is about 750 N/m near 900 Hz.",
        750.0, "N/m", "paper section 7", 0.03, _PRINT, m.finger_stiffness_maximum, scene="paper",
    ),
    Check(
        "PAP-2", "validation",
        "The finger's damping starts at about 0.7 N s/m.",
        0.7, "N s/m", "paper section 7", 0.05, _PRINT, m.finger_damping_start, scene="paper",
        explained="the fit gives 0.82 N s/m at 10 Hz and passes 0.7 N s/m near 30 Hz; the text "
        "speaks of low frequencies in general",
        known=0.170,
    ),
    Check(
        "PAP-4", "validation",
        "On the linear support 1 um at 1000 Hz takes 2.5 to 4 V.",
        (2.5, 4.0), "V", "paper section 6, Fig 17", 0.0, "the range that the paper states",
        m.threshold_voltage_1000, scene="paper",
        explained="1 kHz lies beside the minimum at 934 Hz, where the linear model hardly moves; a "
        "head that rocks on its stop moves more there (rows ROCK-14, ROCK-15), though not enough",
        known=9.72,
    ),
    Check(
        "PAP-5", "validation",
        "At 1000 Hz the loaded deflection at 50 V is at least the smallest that was measured held.",
        (13.6e-6, 72.4e-6), "m", "paper section 6, Fig 15 right", 0.0, "the span of the measured "
        "curve",
        m.paper_end_deflection, scene="paper",
        explained="beside the model's minimum at 934 Hz; the measurement, under 50 g on skin "
        "imitation and not under a finger at 2.5 g, has none so deep. The paper says of its own "
        "simulation that it falls below the measurement",
        known=-0.9143,
    ),
    Check(
        "PAP-6", "validation",
        "The line fitted to the deflection over frequency falls as the measured one does.",
        -3.441e-8, "m/Hz", "paper section 6, Fig 15 right", 2e-4, "four printed digits; that it "
        "falls follows from its start near the simulated 45 um and the span of 13.6 to 72.4 um, "
        "which a rising line of this slope would leave",
        m.paper_slope, scene="paper",
        explained="another load, 50 g on skin imitation in place of a finger at 2.5 g: rows PAD-1 "
        "to PAD-6 have that one",
        known=0.1017,
    ),
    Check(
        "PAP-7", "validation",
        "The voltage at which 2 um (threshold at the lowest frequency) is reached is about 8 V.",
        8.0, "V", "paper section 6, Fig 17", 0.1, _PRINT, m.threshold_voltage_start, scene="paper",
        explained="not settled: no constant factor mends this row and PAP-4 together, and at this "
        "voltage a rocking head is still linear. A finger pressed with 50 g resists more than the "
        "one of 2.5 g that was measured, unless all sixteen tips share it: then each bears 3.1 g",
        known=-0.7245,
    ),
    Check(
        "PAP-8", "validation",
        "The voltage at which 0.2 um (the threshold at 250 Hz) is reached is about 3 V.",
        3.0, "V", "paper section 6, Fig 17", 0.1, _PRINT, m.threshold_voltage_250, scene="paper",
        explained="as PAP-7",
        known=-0.8444,
    ),
    *PAD_CHECKS,
)  # fmt: skip
