"""Do error bars hold?  Random devices, each number with its bar against a much better answer."""
