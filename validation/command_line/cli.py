"""Command line.

Words and progress go to stderr, results to stdout; bad input ends with one sentence and
exit code 2.  Heavy libraries are imported by the commands that need them.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import os
import re
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.exit import end_message, explained, unwind_on_signal
from tactgen.validation.command_line.streams import drop_output, say, usable_streams

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

#: numpy's BLAS sees many small products here: with two threads the solid model and the magnetic
#: field cost 15 to 50 % more processor time for no clear gain in real time, and on a busy
#: machine they wait for each other.  Read once, when numpy is loaded, which no module above
#: does; the sparse solver's threads are in fem.solvers.pardiso.
_BLAS_THREADS = "OPENBLAS_NUM_THREADS"
#: Address space of the numerical libraries (bytes): 0.42 GB was seen.  With less OpenBLAS waits for
#: memory without end, and MKL ends the process.
_LEAST = 500_000_000

#: Where the commands are declared.
_HOME = "tactgen.validation.command_line.commands"
#: The commands in the order of the help, by the module that declares them where it has several.
_COMMANDS = {
    **dict.fromkeys(
        ("report", "solve", "view", "whatif", "compare", "design", "sensitivity", "identify",
         "backbone", "positions", "simulate", "plan", "bill", "export", "materials"), ""
    ),
    **dict.fromkeys(("verify", "coverage", "calibrate", "stress", "bench"), "evidence"),
    **dict.fromkeys(("scenes", "cache", "init", "completion"), "without_solving"),
}  # fmt: skip

#: Arguments whose emptiness their readers speak of.
_SPOKEN_OF = ("scene", "measured", "frequency", "only")


_EXAMPLES = """\
examples:
  tactgen solve --model tmm                      main quantities of the paper's actuator
  tactgen init mine.toml                         scene file with every key
  tactgen solve mine.toml --set bimorph.length=25mm
  tactgen report mine.toml --out report          verification report
  eval "$(tactgen completion)"                   completion for this shell

tactgen solve --help lists all quantities and models. tactgen scenes lists the built-in scenes,
tactgen materials the library of materials.
"""


class _Parser(argparse.ArgumentParser):
    #: Makes description and epilog when help is asked for: what they list costs an import.
    listing: Callable[[], tuple[str, str]] | None = None

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        # "-1ms" is a value, which its reader refuses, and no option
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def format_help(self) -> str:
        """Help text with its lists."""
        if self.listing is not None:
            self.description, self.epilog = self.listing()
        return super().format_help()

    def _print_message(self, message: str, file: SupportsWrite[str] | None = None) -> None:
        """Write help; argparse's own takes no notice of a full disk."""
        if message and file is not None:
            file.write(message)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, and refuse leftover arguments."""
        found, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"unrecognized arguments: {' '.join(left)}")
        for action in self._actions:
            _refuse_empty(action, getattr(found, action.dest, None))
        return found, left

    def error(self, message: str) -> NoReturn:
        """Report a usage error the way all bad input is reported."""
        raise InputError(f"{message}{self._nearest(message)}; see {self.prog} --help")

    def _nearest(self, message: str) -> str:
        """Nearest command, choice or option to a misspelt one."""
        from tactgen.geometry.synonyms import nearest

        chosen = re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message)
        if chosen:
            return nearest(chosen[1], re.findall(r"[^', ]+", chosen[2]))
        unknown = re.search(r"unrecognized arguments: --([a-z0-9._-]+)", message)
        if not unknown:
            return ""
        options = [
            option[2:] for action in self._actions for option in action.option_strings
            if option.startswith("--")
        ]  # fmt: skip
        key = unknown[1].replace("-", "_")
        one = re.sub("ies$", "y", unknown[1]).removesuffix("s")
        if one in options:  # which is repeated for several
            return f' (did you mean "--{one}"?)'
        if "set" in options:
            from tactgen.validation.scene.keys import is_scene_key

            if is_scene_key(key):
                return f' (did you mean "--set {key}=…"?)'
        # their dashes would make all of them alike
        return nearest(unknown[1], options).replace('"', '"--', 1)


class _Version(argparse.Action):
    """``--version``: looked up only when asked for."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        """Print the version and end."""
        from importlib.metadata import version

        print(f"tactgen {version('tactgen')}")
        parser.exit()


def _check_settings() -> None:
    """Refuse bad settings now, not after meshing."""
    from tactgen.fem.solvers.pardiso import VARIABLE, thread_count
    from tactgen.geometry.cad.system_libraries import require_room
    from tactgen.geometry.store.store import LIMIT, size_limit

    require_room(_LEAST, "numpy, scipy and MKL")
    if VARIABLE in os.environ:
        thread_count()
    if LIMIT in os.environ:
        size_limit()


def _spare_imports() -> None:
    """Keep libraries from loading unneeded parts, some 40 ms of an answer."""
    import numpy as np

    # scipy takes all of numpy's names over, of which this one is a compiler's front end
    np.f2py = None  # type: ignore[assignment]
    # else the metadata of all packages is searched for plugins
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    os.environ.setdefault(_BLAS_THREADS, "1")
    # pictures go to files: a notebook's backend may not even be installed here
    os.environ["MPLBACKEND"] = "agg"
    scene, code = "", 0
    try:
        usable_streams()
        with unwind_on_signal(), contextlib.suppress(SystemExit):  # --help
            options = _parser(_command(arguments)).parse_args(arguments)
            scene = getattr(options, "scene", "")
            scene = "paper" if scene is None else scene
            _check_settings()
            _spare_imports()
            code = options.run(options)
        sys.stdout.flush()
    except KeyboardInterrupt as interrupt:
        code, text = end_message(interrupt)
        say(text)
    except BrokenPipeError:
        drop_output()
        return 141
    except Exception as error:
        words = explained(error, scene)
        if words is None:
            raise
        say(words)
        return 2
    return code


def _refuse_empty(action: argparse.Action, value: object) -> None:
    """Refuse an option without a value, which would be as good as not there, and a file "-"."""
    # scenes, measurements and frequencies have words of their own
    if not isinstance(value, str) or action.dest in _SPOKEN_OF:
        return
    name = next(reversed(action.option_strings), action.metavar or action.dest)
    if not value.strip():
        remedy = "give it a value" if action.required else "give it a value or remove it"
        raise InputError(f"{name} is empty; {remedy}")
    if value == "-":
        raise InputError(f'{name} = "-" is no name of a file; name one')


def _command(arguments: Sequence[str] | None) -> str | None:
    """Command that is asked for, None where all must be known."""
    first = next(iter(sys.argv[1:] if arguments is None else arguments), "")
    return first if first in _COMMANDS and first != "completion" else None


def _parser(only: str | None = None) -> argparse.ArgumentParser:
    """Parser of all commands, or of one: to declare all takes a tenth of an answer."""
    parser = _Parser(
        prog="tactgen",
        description="Verification suite for a tactile generator: a piezo bimorph on a "
        "reluctance actuator, by lumped, transfer-matrix, beam and solid models.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=_EXAMPLES,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    parser.set_defaults(run=lambda _: _help(parser))
    added = parser.add_subparsers(title="commands", metavar="COMMAND")
    for name in _COMMANDS if only is None else (only,):
        home = _COMMANDS[name]
        module = importlib.import_module(f"{_HOME}.{home or name}")
        getattr(module, f"add_{name}" if home else "add")(added)
    return parser


def commands() -> dict[str, argparse.ArgumentParser]:
    """Commands by name with their options."""
    found: dict[str, argparse.ArgumentParser] = {}
    for action in _parser()._actions:
        if isinstance(action, argparse._SubParsersAction):
            found.update(action.choices)
    return found


def _help(parser: argparse.ArgumentParser) -> int:
    print(parser.format_help(), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
