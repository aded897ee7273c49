"""What if: a scene at many points of any of its keys, by any model; only what changed is solved."""
