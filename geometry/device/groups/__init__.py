"""The parameters in groups, each with unit, default, source and range."""
