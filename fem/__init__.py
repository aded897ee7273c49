"""Field models on a mesh: beam elements, the piezoelectric solid, port reduction.

May import geometry and, of tmm, the port algebra only: what a field model computes
must owe nothing to the closed forms it is compared with.
"""
