"""The display on any model of its generators."""
