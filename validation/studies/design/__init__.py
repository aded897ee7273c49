"""Design questions of the paper: which length, and which voltage is felt."""
