"""The display: every part placed, what is clear of what, the bill of parts, room for traces."""
