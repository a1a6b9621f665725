"""The base class of exported routines, where earlier versions had it."""

from homebot import apps


def __getattr__(name: str) -> object:
    if name == "RoutineApp":
        return apps.__getattr__(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
