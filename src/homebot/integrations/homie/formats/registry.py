"""Registry of the devices of one version of Homie, and their descriptions. Pure, and bounded."""

from dataclasses import dataclass
from typing import Generic, TypeVar

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, DeviceWithdrawn
from homebot.devices.identity import identifiers
from homebot.integrations.homie.formats.model import STATES, HomieDevice, availability_of
from homebot.integrations.homie.formats.parts import build_parts


@dataclass(slots=True)
class RegisteredDevice:
    """A device of a registry; *size* is the memory that it takes."""

    is_described: bool = False
    size: int = 0


DeviceT = TypeVar("DeviceT", bound=RegisteredDevice)


class Registry(Generic[DeviceT]):
    """At most *most* devices by topic, of *memory* characters together; described ones are never dropped.

    Attributes:
        ignored: Number of invalid nodes and properties.
        refused: Number of refused attributes and documents.
    """

    def __init__(self, most: int, memory: int) -> None:
        self.ignored = 0
        self.refused = 0
        self.devices: BoundedDict[DeviceT] = BoundedDict(most, lambda device: self.reserve(device, 0))
        self._left = memory

    @property
    def dropped(self) -> int:
        """Number of dropped devices, attributes and documents."""
        return self.devices.dropped + self.refused

    def announce(self, device: DeviceT, whole: HomieDevice, domain: str, state: str) -> tuple[AnnouncementEvent, ...]:
        """Return the description of *device*, or its withdrawal if it has no parts."""
        self.ignored += whole.ignored
        described = _describe(whole, domain, is_alive=bool(STATES[state]))
        if described is None:
            return self.withdraw(device, whole.topic, "it no longer has any nodes")
        self.devices.pin(whole.topic)
        device.is_described = True
        return (described,)

    def withdraw(
        self, device: DeviceT, name: str, why: str, *, is_final: bool = False
    ) -> tuple[AnnouncementEvent, ...]:
        """Return the withdrawal of *device* if it was described."""
        was_described, device.is_described = device.is_described, False
        return (DeviceWithdrawn(name, why, is_final=is_final),) if was_described else ()

    def reserve(self, device: DeviceT, size: int) -> bool:
        """Let *device* take *size* of the memory; return False, and count that, if it is not there."""
        if size - device.size > self._left:
            self.refused += 1
            return False
        self._left -= size - device.size
        device.size = size
        return True


def _describe(device: HomieDevice, domain: str, *, is_alive: bool) -> DeviceAnnounced | None:
    """Return the description of *device*; None if it has no parts itself, as a bridge.

    Its identifier is its id in its domain, with a hardware address if the id ends with one. The ``$mac`` of version 4
    belongs to the publishing computer, perhaps of many devices.
    """
    parts = build_parts(device)
    if not parts:
        return None
    return DeviceAnnounced(
        key=device.topic,
        convention="homie",
        native=True,
        whole_device=True,
        identifiers=identifiers((f"{domain}/{device.id}",)),
        name=device.name,
        parts=parts,
        topic=f"{device.topic}/$state",
        facts={**device.facts, **({"type": device.type} if device.type else {})},
        availability=availability_of(device.topic, device.root),
        owns=(device.topic,),
        implies_alive=is_alive,
    )
