"""Scenes driven to extremes: every model against a second one, the machine against its limits."""
