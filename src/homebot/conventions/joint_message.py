"""One message for several settings of a part, in protocols whose messages have a member for each. Pure."""

from collections.abc import Callable, Mapping

from homebot.devices.gateway_messages import Command

__all__ = ["join", "merged"]


def merged(first: Mapping[str, object], second: Mapping[str, object]) -> dict[str, object] | None:
    """Return the members of both objects, and of objects in them; None if they differ in a member that both have."""
    found = dict(first)
    for key, value in second.items():
        known = found.get(key)
        both = merged(known, value) if isinstance(known, dict) and isinstance(value, dict) else None
        if both is None and key in found and known != value:
            return None
        found[key] = value if both is None else both
    return found


def join(
    command: Command, write: Callable[[Command], Mapping[str, object]]
) -> tuple[Mapping[str, object], tuple[str, ...]]:
    """Return the message of *command* with those of its further settings that do not contradict it, and their names.

    Args:
        write: Returns the message of a command with one setting; raises RefusedError.
    """
    first, *others = command.singly()
    message, along = write(first), list[str]()
    for one in others:
        if (both := merged(message, write(one))) is not None:
            message = both
            along.append(one.capability)
    return message, tuple(along)
