"""Plan, stages, solution, error bars: how a question is answered."""
