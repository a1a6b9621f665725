"""What programs import to catch the end of a spin."""

__all__ = ["ExternalShutdownException"]


class ExternalShutdownException(Exception):
    """The end of the graph while a node spins; here ``spin`` returns instead."""
