"""The one exception that a user, not a developer, has to act on."""


class InputError(ValueError):
    """Input that cannot be used, explained in one sentence.

    The sentence names the field, the value with its unit, and the remedy.  The
    command line prints it and exits with code 2.
    """


class CoarseGridError(InputError):
    """A grid too coarse for any answer at one point of a field, in one sentence."""


class MeshError(InputError):
    """A mesh that could not be made, or that did not pass its checks, in one sentence."""
