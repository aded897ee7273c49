"""Which values of some keys meet the aims best: a bounded search over a study's answers."""
