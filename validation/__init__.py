"""What people ask: scenes, plans, cross-checks, reports, pictures, the command line.

The only package that may import all others.
"""

import os

# numpy's BLAS sees many small products here: with two threads the solid model and the magnetic
# field cost 15 to 50 % more processor time for no clear gain in real time, and on a busy
# machine they wait for each other.  Read once, when numpy is loaded; the sparse solver's
# threads are in fem.solvers.threads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
