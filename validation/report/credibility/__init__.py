"""How far a report can be trusted, on the scale of NASA-STD-7009: levels earned by its own rows."""
