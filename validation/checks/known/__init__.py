"""Cases with published or exact answers, declared: what the suite's models must reproduce."""
