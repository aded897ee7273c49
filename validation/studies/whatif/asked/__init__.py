"""What a study asks: axes, values drawn, the statement from which it is gone on with."""
