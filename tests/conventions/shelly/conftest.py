import json
from collections.abc import Callable

import pytest

from homebot.conventions.description import AnnouncementEvent, DescribedPart, DeviceAnnounced
from homebot.conventions.shelly import Shelly, ShellySettings

Say = Callable[..., tuple[AnnouncementEvent, ...]]


@pytest.fixture
def shelly() -> Shelly:
    return Shelly(ShellySettings())


@pytest.fixture
def say(shelly: Shelly) -> Say:
    """Says a message to the convention; what is no text is spelled in JSON."""

    def say(topic: str, payload: object, *, retained: bool = False) -> tuple[AnnouncementEvent, ...]:
        text = payload if isinstance(payload, str) else json.dumps(payload)
        return shelly.read_message(topic, text.encode(), retained=retained)

    return say


@pytest.fixture
def part() -> Callable[[tuple[AnnouncementEvent, ...], str], DescribedPart]:
    """Finds a part in what was heard last."""

    def part(heard: tuple[AnnouncementEvent, ...], part_id: str) -> DescribedPart:
        (device,) = [one for one in heard if isinstance(one, DeviceAnnounced)]
        (found,) = [one for one in device.parts if one.part.id == part_id]
        return found

    return part
