"""Where the models' numerics are driven to their limits: the runs behind ``tactgen stress``."""
