"""Told to end, by Ctrl-C, SIGTERM or a terminal that closes: unwind, so that no half file stays."""

from __future__ import annotations

import contextlib
import errno
import signal
import threading
from collections.abc import Iterator

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.streams import drop_output

# Windows has no SIGHUP
_SIGNALS = (signal.SIGINT, signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else []))


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

    def end(number: int, _: object) -> None:
        nonlocal told
        told = told or number
        raise TerminationRequest(told)

    heard = [number for number in _SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, end) for number in heard}
    try:
        yield
    except Exception as error:
        if told:
            raise TerminationRequest(told) from error
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


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
