"""Put beside a report what makes it checkable: numbers, metadata, checksums."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tactgen.geometry.files import write_text
from tactgen.validation.report.provenance import checksums, crate, record


def unseal(folder: Path) -> None:
    """Take away the checksums of an earlier report, which the next one makes untrue."""
    (folder / checksums.FILE).unlink(missing_ok=True)


def seal(folder: Path, made: record.Record, pages: Sequence[str]) -> None:
    """Write numbers, metadata and checksums beside a report's pages.

    The checksums come last: where they are, the rest is whole.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    write_text(folder / record.FILE, record.record_text(made))
    names = (*pages, record.FILE)
    write_text(folder / crate.FILE, crate.crate_text(folder, names, made))
    checksums.write_checksums(folder, (*names, crate.FILE))
