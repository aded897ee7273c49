"""Questions of many solutions: design, identification, uncertainty."""
