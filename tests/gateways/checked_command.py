"""Commands as a gateway gets them: checked against the part, and numbers on its grids."""

from homebot.control.command import device_settings
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Part, check_setting
from homebot.devices.value import PlainValue, Value


def checked_command(
    part: Part, capability: str, value: PlainValue, *, transition: float = 0.0, code: str = ""
) -> Command:
    """A command to *part*; RefusedError for one that does not fit."""
    check_setting("key", part, capability, value)
    if capability not in ("level", "fan_speed") or value != 0:  # 0 is another setting there: off
        (value,) = device_settings({capability: value}, part).values()
    wanted = Value.of(value)
    return Command(key="key", part=part.id, capability=capability, value=wanted, transition=transition, code=code)
