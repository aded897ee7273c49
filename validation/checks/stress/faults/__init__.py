"""Commands under bad circumstances: killed, out of room, out of memory, two at once, no home."""
