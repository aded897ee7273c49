"""Commands that ask many solutions."""
