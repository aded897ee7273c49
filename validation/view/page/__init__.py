"""The page in which modes and fields move: data, script and style in one file."""
