"""The command line's first and last step, where Ctrl-C just ends the process.

Python's own answer would be a traceback of whatever is being loaded or taken apart.
"""

import signal
import sys


def main() -> int:
    """Run the command line and return the exit code."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from tactgen.validation.command_line.cli import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
