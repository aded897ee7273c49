"""Two scenes or two studies side by side: what differs in input, and in every answer."""
