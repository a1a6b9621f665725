"""The base class of exported routines, where earlier versions had it."""

from homebot.apps import RoutineApp

__all__ = ["RoutineApp"]
