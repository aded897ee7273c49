"""The commands of ``tactgen``, one file each: ``add`` declares it, ``run`` does it."""
