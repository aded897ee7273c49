"""Where each size of the device ends to fit, and what is said beyond."""

import math
from functools import partial

from pydantic import ValidationError

from tactgen.geometry.device import parameters as p
from tactgen.geometry.device.checks import check_fit
from tactgen.geometry.errors import InputError

#: Devices that run into different neighbours: a collar, a slot, the end of a long rod.
DEVICES = {
    "paper": p.Device(),
    "in the slot": p.Device(
        bimorph=p.Bimorph(tab_length=2e-3, width=2e-3, bare_below=0.5e-3), rod=p.Rod(length=5.4e-3)
    ),
    "collar": p.Device(sleeve=p.Sleeve(collar_radius=0.905e-3), coil=p.Coil(position=0.1e-3)),
}
SUPPORTS = {"in the slot": p.Support(kind="rod")}
#: A value is tried up to so many times its own and down to this part of it.
FACTOR = 100.0


def refusal(name, group, key, value):
    """Return why a device with one value changed is refused, if it is."""
    device = DEVICES[name]
    try:
        if group:
            part = getattr(device, group)
            changed = {group: type(part)(**{**dict(part), key: value})}
        else:
            changed = {key: value}
        check_fit(p.Device(**{**dict(device), **changed}), SUPPORTS.get(name, p.Support()))
    except InputError as error:
        return str(error)
    except ValidationError:  # no matter of fit
        return ""
    return ""


def limit(refused, value, factor):
    """Return the last value accepted, to 1e-7, and what the next one is told."""
    kept, gone = value, value * factor
    if not refused(gone):
        return None
    while abs(gone - kept) > 1e-7 * abs(kept):
        middle = math.copysign(math.sqrt(kept * gone), kept)
        kept, gone = (kept, middle) if refused(middle) else (middle, gone)
    return [kept, refused(gone)]


def test_where_each_size_ends_to_fit(approved):
    """The last value of every length that goes together with the others, and the sentence."""
    found = []
    for name, device in DEVICES.items():
        sizes = {("", "gap"): device.gap} | {
            (group, key): value
            for group in ("bimorph", "glue", "rod", "coil", "sleeve", "spring")
            for key, value in getattr(device, group)
            if isinstance(value, float) and value
        }
        for (group, key), value in sizes.items():
            refused = partial(refusal, name, group, key)
            for end, factor in (("from", 1.0 / FACTOR), ("up to", FACTOR)):
                if reached := limit(refused, value, factor):
                    found.append("{}.{} {} {:.7g}: {}".format(group, key, end, *reached))
    approved("\n".join(dict.fromkeys(found)))
