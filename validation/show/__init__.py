"""What is seen of a scene and written of it: fields, pages, stills, films, files."""
