"""What commands print with --json: one line of valid JSON, on standard output."""

import json
import math
from dataclasses import dataclass

import numpy as np

from tactgen.validation.command_line.json_output import print_json


@dataclass(frozen=True)
class Record:
    """With what records hold."""

    name: str
    values: np.ndarray
    error: float
    flags: tuple[bool, ...]


def test_any_record_is_one_line_of_valid_json(capsys):
    """What is not finite is null, since JSON knows no other word; nothing goes to stderr."""
    values = np.array([[1.5, np.nan], [np.inf, -2.0]])
    print_json({"all": [Record("tip", values, math.nan, (True, False))], "count": np.int64(3)})
    out, err = capsys.readouterr()
    assert (err, out.count("\n")) == ("", 1)
    record = {"name": "tip", "values": [[1.5, None], [None, -2.0]], "error": None,
              "flags": [True, False]}  # fmt: skip
    assert json.loads(out) == {"all": [record], "count": 3}
