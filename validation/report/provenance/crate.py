"""What a report is, for archives and other programs: metadata after RO-Crate 1.1 (JSON-LD).

The root data set, its files, the program as a SoftwareApplication, and the run that wrote them as
a CreateAction (profile Process Run Crate).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tactgen.validation.report.provenance.checksums import checksum
from tactgen.validation.report.provenance.record import Record

#: Name that the specification asks for.
FILE = "ro-crate-metadata.json"
_SPECIFICATION = "https://w3id.org/ro/crate/1.1"
#: The specification has no term for a checksum; this is that of the profile for runs.
_SHA256 = {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}
_PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
_KINDS = {".html": "text/html", ".json": "application/json", ".pdf": "application/pdf"}


def crate_text(folder: Path, names: tuple[str, ...], record: Record) -> str:
    """Return the metadata of a report's folder with these files."""
    graph = [
        {
            "@id": FILE,
            "@type": "CreativeWork",
            "about": {"@id": "./"},
            "conformsTo": {"@id": _SPECIFICATION},
        },
        _root(names, record),
        {"@id": _PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5"},
        *(_file(folder, name, record) for name in names),
        *_inputs(record),
        *_software(record),
        _run(names, record),
    ]
    context = [f"{_SPECIFICATION}/context", _SHA256]
    return json.dumps({"@context": context, "@graph": graph}, indent=1) + "\n"


def _root(names: tuple[str, ...], record: Record) -> dict[str, Any]:
    described = record.scene.get("description") or "no description"
    return {
        "@id": "./",
        "@type": "Dataset",
        "name": f"Verification report: {record.name}",
        "description": f"Verification report of the scene {record.name}: {described}.",
        "datePublished": record.written,
        "license": "Not stated by the program: whoever wrote the scene decides.",
        "conformsTo": {"@id": _PROFILE},
        "hasPart": [{"@id": name} for name in names],
        "mentions": [{"@id": "#run"}],
    }


def _file(folder: Path, name: str, record: Record) -> dict[str, Any]:
    path = folder / name
    return {
        "@id": name,
        "@type": "File",
        "name": _MEANING.get(name, name),
        "encodingFormat": _KINDS[path.suffix],
        "contentSize": str(path.stat().st_size),
        "sha256": checksum(path),
        "dateModified": record.written,
    }


_MEANING = {
    "index.html": "The report",
    "report.json": "Scene in SI units, every quantity with its numerical error bar, origin",
    "report.pdf": "The report, printed",
}


def _inputs(record: Record) -> list[dict[str, Any]]:
    return [
        {"@id": f"#input-{digest[:12]}", "@type": "CreativeWork", "name": Path(name).name,
         "sha256": digest}
        for name, digest in record.inputs.items()
    ]  # fmt: skip


def _software(record: Record) -> list[dict[str, Any]]:
    origin = record.made_by
    libraries = {"Python": origin.python, **origin.libraries}
    return [
        {
            "@id": "#program",
            "@type": "SoftwareApplication",
            "name": origin.program,
            "softwareVersion": f"{origin.version}, commit {origin.commit}",
            "sha256": origin.code,
            "operatingSystem": origin.machine,
            "softwareRequirements": [{"@id": f"#{name}"} for name in libraries],
        },
        *(
            {"@id": f"#{name}", "@type": "SoftwareApplication", "name": name, "version": version}
            for name, version in libraries.items()
        ),
    ]


def _run(names: tuple[str, ...], record: Record) -> dict[str, Any]:
    inputs = [{"@id": f"#input-{digest[:12]}"} for digest in record.inputs.values()]
    return {
        "@id": "#run",
        "@type": "CreateAction",
        "name": f"tactgen report {record.name}",
        "instrument": {"@id": "#program"},
        "object": inputs,
        "result": [{"@id": name} for name in names],
        "endTime": record.written,
    }
