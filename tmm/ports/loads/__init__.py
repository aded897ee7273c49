"""What the tip may touch besides constant springs: measured tables, their passive fits, skin."""
