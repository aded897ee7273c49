"""Fields of a scene by its models: one value that pages, pictures and files are made of."""
