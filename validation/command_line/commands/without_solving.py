"""``tactgen scenes``, ``init``, ``cache`` and ``completion``, which solve nothing."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.streams import print_json


def add_scenes(commands: Commands) -> None:
    """Declare ``scenes``."""
    commands.add_parser("scenes", help="list the built-in scenes").set_defaults(run=_scenes)


def _scenes(_: argparse.Namespace) -> int:
    from tactgen.validation.scene.files import built_in_scenes

    for name, description in built_in_scenes().items():
        print(f"{name:12} {description}")
    return 0


def add_init(commands: Commands) -> None:
    """Declare ``init``."""
    parser = commands.add_parser("init", help="write a scene file with every key")
    parser.add_argument("file", metavar="FILE.toml")
    parser.set_defaults(run=_init)


def _init(options: argparse.Namespace) -> int:
    from tactgen.validation.scene.template import write_template

    print(write_template(Path(options.file)))
    return 0


def add_cache(commands: Commands) -> None:
    """Declare ``cache``."""
    parser = commands.add_parser("cache", help="show or clear the cached results")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--info", action="store_true", help="list the cached results (default)")
    what.add_argument("--clear", action="store_true", help="remove all cached results")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=_cache)


def _cache(options: argparse.Namespace) -> int:
    from tactgen.geometry.store.store import clear, holdings, size_limit, store_folder

    held = holdings()
    if options.clear:
        clear()
    entries, size = sum(h.entries for h in held.values()), sum(h.size for h in held.values())
    if options.json:
        kinds = {kind: {"entries": h.entries, "bytes": h.size} for kind, h in held.items()}
        found = {"folder": str(store_folder()), "limit": size_limit(), "kinds": kinds}
        print_json({**found, "cleared": options.clear})
        return 0
    for kind, h in held.items():
        print(f"{kind:24} {h.entries:6}  {_readable(h.size):>9}")
    done = "removed from" if options.clear else "in"
    print(f"{entries} entries, {_readable(size)} {done} {store_folder()}")
    if not options.clear:
        print(f"at most {_readable(size_limit())} (TACTGEN_CACHE_LIMIT), oldest use goes first")
    return 0


def _readable(size: int) -> str:
    """Size (bytes) in decimal units, as disks are sold."""
    for unit, least in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= least:
            return f"{size / least:.3g} {unit}"
    return f"{size} B"


_BASH = """\
# tactgen: completion for bash (zsh: autoload -U bashcompinit; bashcompinit; then the same)
# use:  eval "$(tactgen completion)"      or put that line into ~/.bashrc
_tactgen() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}" words=""
  case "$before" in
    --model) words="{models}" ;;
    --quantity) words="{quantities}" ;;
    --set|--key|--vary) words="{keys}"; compopt -o nospace 2>/dev/null ;;
    *) case "${{COMP_WORDS[1]}}" in
{options}
      esac ;;
  esac
  [ "$COMP_CWORD" -eq 1 ] && words="{commands}"
  COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o default -F _tactgen tactgen
"""


def add_completion(commands: Commands) -> None:
    """Declare ``completion``."""
    parser = commands.add_parser(
        "completion", help="print what bash or zsh needs to complete commands, options and keys"
    )
    parser.set_defaults(run=_completion, commands=commands)


def _completion(options: argparse.Namespace) -> int:
    from tactgen.validation.catalogue.models import MODELS
    from tactgen.validation.catalogue.quantities import QUANTITIES
    from tactgen.validation.scene.files import built_in_scenes
    from tactgen.validation.scene.keys import scene_keys

    parsers: dict[str, argparse.ArgumentParser] = options.commands.choices
    scenes = " ".join(built_in_scenes())
    lines = []
    for name, parser in parsers.items():
        actions = parser._actions
        words = [option for action in actions for option in action.option_strings]
        takes_scene = any(action.dest == "scene" for action in actions)
        told = " ".join([*words, *([scenes] if takes_scene else [])])
        lines.append(f'      {name}) words="{told}" ;;')
    print(
        _BASH.format(
            models=" ".join([*MODELS, "all"]), quantities=" ".join([*QUANTITIES, "all"]),
            keys=" ".join(f"{key}=" for key in scene_keys()), options="\n".join(lines),
            commands=" ".join(parsers),
        ),
        end="",
    )  # fmt: skip
    return 0
