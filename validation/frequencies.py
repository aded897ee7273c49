"""Lists of frequencies as a user writes them: ``100,200`` or ``10:2000:200:log``."""

from __future__ import annotations

import math

from geometry.errors import InputError

#: Largest sweep that one request may ask for.
_MOST = 1_000_000
_FACTORS = {"": 1.0, "hz": 1.0, "khz": 1e3, "mhz": 1e6}


def parse_frequencies(text: str) -> tuple[float, ...]:
    """Return frequencies in Hz from ``LIST`` or ``START:STOP:N[:log]``; numbers are Hz.

    Raises
    ------
    InputError
        If a number, the count or the spacing cannot be used.
    """
    if ":" not in text:
        return tuple(_one(part, text) for part in text.split(","))
    parts = text.split(":")
    if len(parts) not in (3, 4) or (len(parts) == 4 and parts[3].strip() not in ("log", "lin")):
        raise InputError(
            f'frequency = "{text}" is not START:STOP:N or START:STOP:N:log; '
            'write for example "10:2000:200"'
        )
    start, stop = _one(parts[0], text), _one(parts[1], text)
    count = _count(parts[2], text)
    if count == 1:
        return (start,)
    if len(parts) == 4 and parts[3].strip() == "log":
        if start <= 0.0 or stop <= 0.0:
            raise InputError(
                f'frequency = "{text}" cannot be spaced logarithmically from {start:g} Hz; '
                "start above 0 Hz"
            )
        ratio = math.log(stop / start) / (count - 1)
        inner = [start * math.exp(ratio * i) for i in range(1, count - 1)]
    else:
        step = (stop - start) / (count - 1)
        inner = [start + step * i for i in range(1, count - 1)]
    return (start, *inner, stop)


def _count(part: str, text: str) -> int:
    try:
        count = int(part)
    except ValueError:
        count = 0
    if not 1 <= count <= _MOST:
        raise InputError(
            f'frequency = "{text}" asks for "{part.strip()}" points; '
            f"give a whole number from 1 to {_MOST}"
        )
    return count


def _one(part: str, text: str) -> float:
    stripped = part.strip().lower().replace(" ", "")
    number = stripped.rstrip("hzkm")
    unit = stripped[len(number) :]
    try:
        value = float(number) * _FACTORS[unit]
    except (ValueError, KeyError):
        raise InputError(
            f'frequency = "{text}" has "{part.strip()}", which is not a frequency; '
            'write for example "500" or "0.5 kHz"'
        ) from None
    if not math.isfinite(value) or value < 0.0:
        raise InputError(
            f'frequency = "{text}" has {part.strip()} Hz; '
            "frequencies must be finite and not negative"
        )
    return value
