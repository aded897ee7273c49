"""Evidence: known answers, random devices, extremes, faults and run time against error."""
