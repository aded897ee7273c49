"""Questions of many solutions: design, identification, sensitivity, runs in time, what if."""
