"""Pictures, figures and numbers as people see them."""
