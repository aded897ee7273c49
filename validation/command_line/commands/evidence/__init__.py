"""The commands that prove something: known answers, error bars, limits, run time against error."""
