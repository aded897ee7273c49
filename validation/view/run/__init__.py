"""A run of the generator as it is seen: pictures for films, and a page in which it moves."""
