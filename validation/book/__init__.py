"""The verification book: every known answer with its evidence, one page a case."""
