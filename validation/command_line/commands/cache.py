"""``tactgen cache``: list and empty the store."""

from __future__ import annotations

import argparse

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.streams import print_json

#: Units of the table, largest first.
_UNITS = (("GB", 1e9), ("MB", 1e6), ("kB", 1e3))


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "cache", help="show or clear the results that are kept for the next run"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--info", action="store_true", help="show what is kept (default)")
    what.add_argument("--clear", action="store_true", help="remove all of it")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
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
    for unit, worth in _UNITS:
        if size >= worth:
            return f"{size / worth:.3g} {unit}"
    return f"{size} B"
