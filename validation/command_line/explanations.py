"""What is said of an error that ended a command."""

from __future__ import annotations

import errno

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.streams import drop_output

_MORE = "free some, raise the limit of the process (ulimit -v), or ask for less"


def explained(error: Exception, scene: str) -> str | None:
    """Sentence for an error that a user can act on, None for a mistake of ours."""
    if isinstance(error, InputError):
        return str(error)
    short = _of_memory(error) or _of_a_full_disk(error)
    if short:
        return short
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


def _of_memory(error: Exception) -> str:
    """Sentence for what comes of too little memory, "" for anything else."""
    if isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM:
        return f"there is not enough memory for this; {_MORE}"
    if isinstance(error, ImportError) and not (error.name or "").startswith("tactgen"):
        return (
            f"a library cannot be loaded ({error}); if memory is short, {_MORE}; else install "
            "tactgen's packages again (make setup)"
        )
    if isinstance(error, SystemError):  # a library's: it failed without making an error of it
        return f"a library failed ({error}), as it does where memory is short; {_MORE}"
    return ""


def _of_a_full_disk(error: Exception) -> str:
    """Sentence for a compiled module that Python left cut short, "" for all else.

    Where the disk is full it writes what goes in, takes that for the whole, and reads it ever
    after.
    """
    at = error.__traceback__
    while at is not None and at.tb_next is not None:
        at = at.tb_next
    if at is None or at.tb_frame.f_code.co_name != "_compile_bytecode":
        return ""
    path = at.tb_frame.f_locals["bytecode_path"]
    return f"{path} is cut short, as a full disk leaves it; remove it and run this again"
