"""The accessories that an accessory server lists, checked. Pure.

Source: HomeKit Accessory Protocol Specification, Non-Commercial Version, Release R2: 2.3 (attribute database), 6.3
(accessory objects), 6.6 (JSON).
"""

from dataclasses import dataclass, field
from typing import Final, TypeAlias

from homebot.conventions.payload import as_fields, clean_text, shown
from homebot.errors import WireError
from homebot.support.numbers import finite_number, whole_number

CharacteristicId: TypeAlias = tuple[int, int]
"""Accessory ID and instance ID."""

MAX_ACCESSORIES: Final = 150
MAX_SERVICES: Final = 100
MAX_CHARACTERISTICS: Final = 100
"""The limits of the specification (2.3) are 150 accessories, and 100 services and characteristics of each."""

_BASE: Final = "-0000-1000-8000-0026BB765291"
_MAX_TEXT_CHARACTERS: Final = 256
_FINEST: Final = 1e-6
"""A finer step is none."""

INFORMATION: Final = "3E"
SLEEP_INTERVAL: Final = "23A"
"""A characteristic of Accessory Runtime Information, which is younger than R2; its name and unit are those of
aiohomekit 4.0 and HAP-NodeJS 1.1."""


@dataclass(eq=False, slots=True)
class HapCharacteristic:
    """A characteristic, with its last known value.

    Attributes:
        type: Its short type, such as ``25`` (On), or a UUID.
        format: ``bool``, ``uint8``, ``float``, ``string``, …
        perms: Its permissions: ``pr`` (read), ``pw`` (write), ``ev`` (events), ``tw`` (timed writes only), …
        bounds: Its smallest and largest value; empty for none.
        valid_values: The values that it can have, where it lists them.
        step: The distance of its values from each other; 0 for any.
    """

    iid: int
    type: str
    format: str
    perms: frozenset[str]
    value: object = None
    bounds: tuple[float, ...] = ()
    valid_values: tuple[int, ...] = ()
    step: float = 0.0

    def encode(self, value: float) -> object:
        """Return *value* as its format has it, within its bounds and in its steps; true as 1, as Apple's devices do.

        ecobee's switch takes no ``true`` (aiohomekit 0.2.37).
        """
        if self.step > 0:
            least = self.bounds[0] if self.bounds else 0.0
            value = round(least + round((value - least) / self.step) * self.step, 6)
        if self.bounds:
            value = min(max(value, self.bounds[0]), self.bounds[1])
        return value if self.format == "float" else round(value)


@dataclass(eq=False, slots=True)
class HapService:
    """A service: one function of an accessory, with its characteristics by their short types, of each the first."""

    iid: int
    type: str
    characteristics: dict[str, HapCharacteristic] = field(default_factory=dict)

    def can(self, kind: str, permission: str) -> bool:
        """Return whether it has the characteristic *kind* with a permission."""
        characteristic = self.characteristics.get(kind)
        return characteristic is not None and permission in characteristic.perms

    def number(self, kind: str) -> float | None:
        """Return the value of a characteristic that is a number, or true (1) or false (0); None for unknown."""
        characteristic = self.characteristics.get(kind)
        value = None if characteristic is None else characteristic.value
        return float(value) if isinstance(value, bool) else finite_number(value)

    def text(self, kind: str) -> str:
        """Return the value of a characteristic that is a text; empty for none."""
        characteristic = self.characteristics.get(kind)
        return (
            clean_text(characteristic.value)[:_MAX_TEXT_CHARACTERS]
            if characteristic is not None and isinstance(characteristic.value, str)
            else ""
        )


@dataclass(eq=False, slots=True)
class Accessory:
    """An accessory: a device by itself, or one behind a bridge."""

    aid: int
    services: dict[int, HapService] = field(default_factory=dict)

    @property
    def information(self) -> HapService:
        """The service with its name, maker and serial number; an empty one where it has none."""
        return next(
            (service for service in self.services.values() if service.type == INFORMATION), HapService(0, INFORMATION)
        )

    @property
    def sleeps(self) -> bool:
        """True if its radio sleeps: the interval, in milliseconds, is not 0."""
        return any(service.number(SLEEP_INTERVAL) for service in self.services.values())


def short_type(uuid: object) -> str:
    """Return a type as short as the specification allows: ``43`` for ``00000043-0000-1000-8000-0026BB765291``."""
    text = uuid.upper()[:_MAX_TEXT_CHARACTERS] if isinstance(uuid, str) else ""
    return text.removesuffix(_BASE).lstrip("0") if text.endswith(_BASE) or len(text) <= len("00000043") else text


def parse_accessories(listed: object) -> dict[int, Accessory]:
    """Return the accessories, by their IDs, in the list of their JSON objects.

    Raises:
        WireError: It is not a list of accessories; single invalid services and characteristics are left out.
    """
    if not isinstance(listed, list) or not listed:
        raise WireError(f"the accessories are {shown(listed)}, not a list")
    accessories: dict[int, Accessory] = {}
    for entry in listed[:MAX_ACCESSORIES]:
        fields = as_fields(entry)
        aid, services = whole_number(fields.get("aid")), fields.get("services")
        if aid is None or aid < 1 or not isinstance(services, list):
            raise WireError(f"an accessory is {shown(entry)}")
        parsed = (_parse_service(service) for service in services[:MAX_SERVICES])
        accessories[aid] = Accessory(aid, {service.iid: service for service in parsed if service is not None})
    return accessories


def _parse_service(data: object) -> HapService | None:
    fields = as_fields(data)
    iid, kind, listed = whole_number(fields.get("iid")), short_type(fields.get("type")), fields.get("characteristics")
    if iid is None or not kind or not isinstance(listed, list):
        return None
    service = HapService(iid, kind)
    for characteristic in map(_parse_characteristic, listed[:MAX_CHARACTERISTICS]):
        if characteristic is not None:
            service.characteristics.setdefault(characteristic.type, characteristic)
    return service


def _parse_characteristic(data: object) -> HapCharacteristic | None:
    fields = as_fields(data)
    iid, kind, perms = whole_number(fields.get("iid")), short_type(fields.get("type")), fields.get("perms")
    if iid is None or not kind or not isinstance(perms, list):
        return None
    least, most = finite_number(fields.get("minValue")), finite_number(fields.get("maxValue"))
    valid = fields.get("valid-values")
    numbers = [int(value) for value in valid if finite_number(value) is not None] if isinstance(valid, list) else []
    if least is not None and least == most:
        numbers = [int(least)]
    return HapCharacteristic(
        iid,
        kind,
        str(fields.get("format"))[:10],
        frozenset(permission for permission in perms if isinstance(permission, str)),
        fields.get("value"),
        (least, most) if least is not None and most is not None and least < most else (),
        tuple(numbers),
        step if (step := finite_number(fields.get("minStep")) or 0.0) >= _FINEST else 0.0,
    )
