"""Field models on a mesh; `fem/weak_forms.py` has all of them as weak forms.

May import geometry and, of tmm, the port algebra only: what a field model computes
must owe nothing to the closed forms it is compared with.
"""
