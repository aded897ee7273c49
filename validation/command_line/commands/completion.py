"""``tactgen completion``: shell completion of commands, options, names and keys."""

from __future__ import annotations

import argparse

from tactgen.validation.command_line.commands.common import Commands

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


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "completion", help="print what bash or zsh needs to complete commands, options and keys"
    )
    parser.set_defaults(run=run, commands=commands)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.catalogue.models import MODELS
    from tactgen.validation.catalogue.quantities import QUANTITIES
    from tactgen.validation.scene.files import built_in_scenes
    from tactgen.validation.scene.scene import scene_keys

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
