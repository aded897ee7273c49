"""How well the numbers are known, given how well the parameters are."""
