"""Layout of the display: placed parts, clearances, bill of parts, traces."""
