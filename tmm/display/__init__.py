"""Many generators side by side: what one does to the others, through board, skin and field."""
