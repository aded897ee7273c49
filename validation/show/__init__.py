"""Fields, pages, stills, films and files of a scene."""
