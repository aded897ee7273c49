"""Told to end, by Ctrl-C, SIGTERM or a terminal that closes: unwind, so that no half file stays.

Not amid the loading of a compiled module, though: one that is interrupted in its initialisation
makes an error of its own of it, or crashes.  The end then waits until it is loaded.  Nor where
Python lets no error out, as an object goes: there it is raised again a little later.
"""

from __future__ import annotations

import contextlib
import errno
import signal
import sys
import threading
from collections.abc import Iterator
from importlib.machinery import ExtensionFileLoader
from types import FrameType

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.streams import drop_output

# Windows has no SIGHUP, and no timer that counts processor time
_SIGNALS = (signal.SIGINT, signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else []))
_HAS_TIMER = hasattr(signal, "setitimer")
#: Signal and timer of the second look whether the module has been loaded; and after how many
#: seconds of processor time.
_LOOK = [signal.SIGVTALRM] if _HAS_TIMER else []
_AGAIN = 0.01
#: What Python runs to load a compiled module.
_LOADERS = {ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__}


class TerminationRequest(KeyboardInterrupt):
    """A signal's number.

    KeyboardInterrupt itself, passing code made of text, as dataclasses are, leaves a mark by which
    ``python -m`` ends as if by Ctrl-C, whatever answered it.
    """


@contextlib.contextmanager
def unwind_on_signal() -> Iterator[None]:
    """Raise :class:`TerminationRequest` where the work is when a signal arrives.

    What is ignored already stays so.  After the signal any error counts as the end: libraries
    that call back make errors of their own of it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    told = 0

    def end(number: int, frame: FrameType | None) -> None:
        nonlocal told
        told = told or number
        if _HAS_TIMER and _loading(frame):
            _look_again()
        else:
            raise TerminationRequest(told)

    def passed_over(raised: sys.UnraisableHookArgs) -> None:
        if _HAS_TIMER and isinstance(raised.exc_value, TerminationRequest):
            _look_again()
        else:
            hook(raised)

    hook, sys.unraisablehook = sys.unraisablehook, passed_over
    heard = [number for number in _SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, end) for number in (*heard, *_LOOK)}
    try:
        yield
    except Exception as error:
        if told:
            raise TerminationRequest(told) from error
        raise
    finally:
        if _HAS_TIMER:
            _look_again(0.0)
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)


def _look_again(after: float = _AGAIN) -> None:
    """Ask for another signal after so many seconds of processor time; of 0 for none."""
    signal.setitimer(signal.ITIMER_VIRTUAL, after)


def _loading(frame: FrameType | None) -> bool:
    """Whether a compiled module is being loaded."""
    while frame is not None:
        if frame.f_code in _LOADERS:
            return True
        frame = frame.f_back
    return False


def end_message(interrupt: KeyboardInterrupt) -> tuple[int, str]:
    """Exit code, 128 and the signal's number as shells have it, and words."""
    number = interrupt.args[0] if interrupt.args else signal.SIGINT
    how = "interrupted" if number == signal.SIGINT else "told to end"
    return 128 + number, f"{how}; nothing half-written was kept"


_MORE = "free some, raise the limit of the process (ulimit -v), or ask for less"


def explained(error: Exception, scene: str) -> str | None:
    """Sentence for an error that a user can act on, None for a mistake of ours."""
    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
        return f"there is not enough memory for this; {_MORE}"
    if isinstance(error, ImportError) and not (error.name or "").startswith("tactgen"):
        return (
            f"a library cannot be loaded ({error}); if memory is short, {_MORE}; else install "
            "tactgen's packages again (make setup)"
        )
    if isinstance(error, SystemError):  # a library's: it failed without making an error of it
        return f"a library failed ({error}), as it does where memory is short; {_MORE}"
    if isinstance(error, OSError):
        reason = (error.strerror or str(error)).lower()
        if error.filename is not None:
            return f"{error.filename} cannot be used ({reason}); make room or choose another place"
        drop_output()
        return f"standard output cannot be written ({reason}); send it somewhere else"
    # by name: importing the solvers costs more than most answers
    names = {kind.__name__ for kind in type(error).__mro__}
    if names & {"LinAlgError", "SolverError", "ArpackError", "ArithmeticError"}:
        reason = str(error) or type(error).__name__
        return (
            f'scene "{scene}" cannot be solved ({reason}); bring the values that it sets closer to '
            "those of the built-in scenes paper and reluctance, or ask for another model with "
            "--set models="
        )
    return None
