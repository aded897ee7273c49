"""Frequencies as a user writes them: ``100,200``, ``10:2000:200:log`` or a TOML list."""

from __future__ import annotations

import math
import re
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.units import FREQUENCY, quoted

#: Largest sweep that one request may ask for.
_MOST = 1_000_000
#: Highest frequency that can be meant (Hz).
_HIGHEST = FREQUENCY.limits[1] if FREQUENCY.limits else math.inf
_REMEDY = 'write for example "500", "0.5 kHz" or "10:2000:200"'


def parse_frequencies(given: Any, stated: str = "") -> tuple[float, ...]:
    """Frequencies in Hz from whatever a scene or a caller states; bare numbers are Hz.

    Parameters
    ----------
    given : number, str, or list of numbers and str
        Text is ``LIST`` or ``START:STOP:N[:log]``; in a list each stands for one frequency.
    stated : str
        How messages repeat what was written, if not as the key ``frequency``.

    Raises InputError if a number, the count or the spacing cannot be used.
    """
    stated = stated or f"frequency = {quoted(given)}"
    if isinstance(given, str) and given.count(":") > 0:
        return _sweep(given, stated)
    parts = given.split(",") if isinstance(given, str) else given
    if not isinstance(parts, list | tuple):
        parts = [parts]
    if not parts or parts == [""]:
        raise InputError(f"{stated} holds no frequency; {_REMEDY}")
    if len(parts) > _MOST:
        raise InputError(f"frequency has {len(parts)} values; give at most {_MOST}")
    return tuple(_one(part, stated) for part in parts)


def _sweep(text: str, stated: str) -> tuple[float, ...]:
    parts = text.split(":")
    if len(parts) not in (3, 4) or (len(parts) == 4 and parts[3].strip() not in ("log", "lin")):
        raise InputError(
            f'{stated} is not START:STOP:N or START:STOP:N:log; write for example "10:2000:200"'
        )
    start, stop = _one(parts[0], stated), _one(parts[1], stated)
    count = _count(parts[2], stated)
    logarithmic = len(parts) == 4 and parts[3].strip() == "log"
    if logarithmic and (start <= 0.0 or stop <= 0.0):
        raise InputError(
            f"{stated} cannot be spaced logarithmically from {start:g} Hz to "
            f"{stop:g} Hz; keep both above 0 Hz"
        )
    if count == 1:
        if start != stop:
            raise InputError(
                f"{stated} asks for 1 point between two ends; write one frequency, such as "
                f'"{start:g}", or at least 2 points'
            )
        return (start,)
    if logarithmic:
        ratio = math.log(stop / start) / (count - 1)
        inner = [start * math.exp(ratio * i) for i in range(1, count - 1)]
    else:
        step = (stop - start) / (count - 1)
        inner = [start + step * i for i in range(1, count - 1)]
    return (start, *inner, stop)


def _count(part: str, stated: str) -> int:
    stripped = part.strip()
    count = int(stripped) if re.fullmatch(r"\d{1,9}", stripped, re.ASCII) else 0
    if not 1 <= count <= _MOST:
        raise InputError(
            f"{stated} asks for {quoted(stripped)} points; give a whole number from 1 to {_MOST}"
        )
    return count


def _one(part: Any, stated: str) -> float:
    value = _hertz(part, stated)
    if not math.isfinite(value) or value < 0.0:
        raise InputError(
            f"{stated} has {quoted(part)}; frequencies must be finite and not negative, in Hz"
        )
    if value > _HIGHEST:
        raise InputError(
            f"{stated} has {quoted(part)}; frequencies must be at most {_HIGHEST * 1e-6:g} MHz"
        )
    return value


def _hertz(part: Any, where: str) -> float:
    """One frequency as a number, of whatever sign and size."""
    if isinstance(part, int | float) and not isinstance(part, bool):
        try:
            return float(part)
        except OverflowError:
            return math.inf
    if not isinstance(part, str):
        raise InputError(f"{where} has {quoted(part)}, which is not a frequency; {_REMEDY}")
    text = part.strip(" \t")
    if text.endswith(("mHz", "mhz")):
        raise InputError(
            f"{where} has {quoted(part)} in millihertz; write MHz for megahertz, or the value in Hz"
        )
    try:
        return FREQUENCY.parse(text.replace("hz", "Hz"), bare=True)
    except ValueError:
        raise InputError(
            f"{where} has {quoted(part)}, which is not a frequency; {_REMEDY}"
        ) from None
