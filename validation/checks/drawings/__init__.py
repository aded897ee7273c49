"""What a case solves, as a drawing for its page: bodies, what holds them, what acts on them."""
