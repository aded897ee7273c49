"""The suite's own checks as declarative rows, and what they measure."""
