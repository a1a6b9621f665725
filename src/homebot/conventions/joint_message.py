"""One message for several settings of a part, in protocols whose messages have a member for each. Pure."""

from collections.abc import Callable, Mapping

from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue


def merged(first: Mapping[str, object], second: Mapping[str, object]) -> dict[str, object] | None:
    """Return the members of both objects, and of objects in them; None if they differ in a member that both have."""
    joined = dict(first)
    for key, value in second.items():
        known = joined.get(key)
        both = merged(known, value) if isinstance(known, dict) and isinstance(value, dict) else None
        if both is None and key in joined and known != value:
            return None
        joined[key] = value if both is None else both
    return joined


def join(
    command: Command, write: Callable[[Command], Mapping[str, object]]
) -> tuple[Mapping[str, object], tuple[str, ...]]:
    """Return the message of *command* with those of its further settings that do not contradict it, and their names.

    Args:
        write: Returns the message of a command with one setting; raises RefusedError.
    """
    values = {single.capability: single.value.plain() for single in command.singly()}
    switch = values.keys() - without_switch(values).keys()
    first, *others = sorted(command.singly(), key=lambda single: single.capability in switch)
    message, along = write(first), [first.capability]
    for single in others:
        if (both := merged(message, write(single))) is not None or single.capability in switch:
            message = message if both is None else both
            along.append(single.capability)
    return message, tuple(along)


def without_switch(values: Mapping[str, PlainValue]) -> Mapping[str, PlainValue]:
    """Return *values* without an "on" that the mode of a thermostat says as well, if that is its switch.

    By itself it would choose a mode, such as ``heat``, before the wanted one.
    """
    is_told = values.get("on_off") is True and values.get("thermostat_mode") not in {None, "off"}
    return {name: value for name, value in values.items() if name != "on_off"} if is_told else values
