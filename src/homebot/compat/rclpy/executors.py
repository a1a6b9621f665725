"""The exception that programs of rclpy catch around a spin."""

__all__ = ["ExternalShutdownException"]


class ExternalShutdownException(Exception):
    """The end of the graph while a node spins; never raised here, since ``spin`` returns instead."""
