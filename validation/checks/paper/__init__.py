"""The paper's printed formulas and figures, audited."""
