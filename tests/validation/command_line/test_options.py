"""Every option of every command is what tests/data/options.json says a second time.

Scripts of users name them: none is lost, renamed or given another default unseen.
"""

import json
from pathlib import Path

import pytest

from tactgen.validation.command_line.cli import commands

KNOWN = json.loads(
    (Path(__file__).parents[2] / "data" / "options.json").read_text(encoding="utf-8")
)

COMMANDS = commands()


def taken(parser):
    """Return what a command takes, by flags or name, without the words of its help."""
    found = {}
    for action in parser._actions:
        kind = type(action).__name__.strip("_").removesuffix("Action")
        said = {
            "kind": kind,
            "to": action.dest,
            "default": None if action.default is None else str(action.default),
            "takes": action.nargs,
            "type": getattr(action.type, "__name__", None),
            "choices": list(action.choices) if action.choices else None,
            "required": action.required,
        }
        name = " ".join(action.option_strings) or action.dest
        found[name] = {key: value for key, value in said.items() if value not in (None, False)}
    return found


def test_no_command_is_added_or_lost():
    """In the order in which help lists them."""
    assert list(COMMANDS) == list(KNOWN)


@pytest.mark.parametrize("command", KNOWN)
def test_options_are_the_known_ones(command):
    """Flags, defaults, how many values, and what may be chosen."""
    assert taken(COMMANDS[command]) == KNOWN[command]
    assert COMMANDS[command].get_default("run").__name__ == "run"
