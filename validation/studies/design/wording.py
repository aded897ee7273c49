"""What a length design found, in sentences."""

from __future__ import annotations

from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.design.length_design import Design

#: Most frequencies of a threshold that are named one by one.
_LISTED = 5
#: What the tip pushes against, by the scene's ``load.kind``.
LOADS = {
    "none": "with a free tip",
    "finger": "under the finger",
    "mass": "with the tip mass",
    "spring_damper": "on spring and damper",
    "table": "under the measured load",
    "pad": "under imitation skin and its weight",
}


def sentences(found: Design) -> tuple[str, ...]:
    """Return all that is to be said of a design."""
    return setting(found), statement(found), feasible(found), present(found), caveat(found)


def setting(found: Design) -> str:
    """Return how the actuator is driven and loaded."""
    scene = found.scene
    return (
        f"Driven with {scene.drive.voltage:g} V, wired in {scene.bimorph.wiring}, "
        f"{LOADS[scene.load.kind]}."
    )


def changed_setting(scene: Scene, asked: Scene) -> str:
    """Return where `asked` is driven or loaded otherwise than the scene; nothing if nowhere."""
    now, own = [], []
    if asked.drive.voltage != scene.drive.voltage:
        now.append(f"at {asked.drive.voltage:g} V")
        own.append(f"{scene.drive.voltage:g} V")
    if asked.load.kind != scene.load.kind:
        now.append(LOADS[asked.load.kind])
        own.append(LOADS[scene.load.kind])
    return f"{' '.join(now)} instead of this scene's {', '.join(own)}" if now else ""


def statement(found: Design) -> str:
    """Return what was found and what decides it."""
    aim = found.aim
    band = f"{aim.band[0]:g} to {aim.band[1]:g} Hz"
    within = f"of {_mm(aim.lengths[0])} to {_mm(aim.lengths[1])}"
    reached = f"|w| / threshold is at least {found.margin:.4g}, lowest at {found.frequency:.4g} Hz"
    if found.limit == "compromise":
        return (
            f"No length {within} keeps |w| / threshold at {aim.margin:g} or more over {band}; "
            f"nearest to it is {_mm(found.length)}, where {reached}."
        )
    if aim.kind == "margin":
        end = " (an end of the range: beyond it there may be more)" if found.limit == "end" else ""
        best = f"{_mm(found.length)}{end}"
        return f"The largest margin {within} over {band} is that of {best}: {reached}."
    if found.limit == "end":
        return (
            f"The shortest length allowed, {_mm(found.length)}, already keeps |w| / threshold at "
            f"{aim.margin:g} or more over {band}: {reached}. The range decides here, not the "
            "threshold."
        )
    return (
        f"The shortest length {within} that keeps |w| / threshold at {aim.margin:g} or more over "
        f"{band} is {_mm(found.length)}; {found.frequency:.4g} Hz decides."
    )


def feasible(found: Design) -> str:
    """Return which lengths keep the margin."""
    if not found.intervals:
        return "No length keeps the margin."
    parts = [f"{_end(i.shortest, i.at_shortest)} to {_end(i.longest, i.at_longest)}"
             for i in found.intervals]  # fmt: skip
    return f"Lengths that keep the margin: {'; '.join(parts)}."


def present(found: Design) -> str:
    """Return how the scene's own length stands."""
    margin, at = found.present
    own, (low, high) = found.scene.bimorph.length, found.aim.lengths
    outside = "" if low <= own <= high else " outside that range,"
    return (
        f"The scene's own length, {_mm(own)},{outside} has |w| / threshold "
        f"{margin:.4g} at worst, at {at:.4g} Hz."
    )


def caveat(found: Design) -> str:
    """Return where the threshold is known."""
    points = [p.frequency for p in found.aim.threshold.points]
    if len(points) > _LISTED:
        listed = f"{len(points)} frequencies from {points[0]:g} to {points[-1]:g} Hz"
    else:
        listed = ", ".join(f"{f:g}" for f in points[:-1]) + f" and {points[-1]:g} Hz"
    between = "" if found.frequency in points else f", as at {found.frequency:.4g} Hz"
    return (
        f"The detection threshold is stated at {listed}; between them it is interpolated, a "
        f"straight line in log-log{between}."
    )


def _end(length: float, at: float | None) -> str:
    return f"{_mm(length)} ({'end of the range' if at is None else f'{at:.4g} Hz decides'})"


def _mm(length: float) -> str:
    return f"{1e3 * length:.5g} mm"
