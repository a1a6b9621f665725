"""Parser of SwitchBot's broadcasts: sensors, and the states of locks, plugs, curtains and bots. Pure.

A device says in the data of its service what it is, in their first byte or the last ones, and how full its battery is,
and the rest beside its address in those of the maker; the oldest devices say all in the former. Their connections, by
which they take commands, are not used.

Source: pySwitchbot 3.1, ``adv_parser.py`` and ``adv_parsers``.
"""

from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from homebot.conventions.bluetooth.broadcast import (
    Advertisement,
    Broadcast,
    BroadcastParser,
    BroadcastValue,
    full_uuid,
    sensor_part,
)
from homebot.devices.part import Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import WireError

MAKER: Final = 0x0969
SERVICES: Final = (full_uuid("fd3d"), full_uuid("0d00"))
ON_BATTERY: Final = 300.0
"""Seconds for which a battery-powered device may be silent."""

_BODY: Final = 8
"""The first byte in the maker's data after the address, a counter and flags."""

_MAX_PPM: Final = 9999
_OPEN_TILT: Final = 50
"""Slats are closed upwards at 100 and downwards at 0."""

_LOCKS: Final = ("locked", "unlocked", "locking", "unlocking", "jammed", "jammed", "unlocked")

_ReadFrame = Callable[[bytes, bytes], PlainValue]
"""Returns a value from the data of the service and of the maker; an IndexError says that they are cut off."""


class _SwitchbotRow(NamedTuple):
    """A value of a model; its type is that of a sensor by default."""

    capability: str
    read: _ReadFrame
    service_type: str = ""


def _bits(**capabilities: tuple[int, int]) -> tuple[_SwitchbotRow, ...]:
    """Return the rows of bits, each with its byte in the maker's data and its mask."""

    def reader(at: int, mask: int) -> _ReadFrame:
        return lambda _service, maker: bool(maker[at] & mask)

    return tuple(_SwitchbotRow(name, reader(at, mask)) for name, (at, mask) in capabilities.items())


def _climate_at(at: int) -> tuple[_SwitchbotRow, ...]:
    """Return the rows of tenths of a degree, degrees with a sign, and humidity, in three bytes; all 0 is unknown."""

    def celsius(_service: bytes, maker: bytes) -> PlainValue:
        tenths, whole, humidity = maker[at], maker[at + 1], maker[at + 2]
        degrees = (whole & 0x7F) + (tenths & 0x0F) / 10
        return None if not degrees and not humidity & 0x7F else degrees if whole & 0x80 else -degrees

    def humidity(service: bytes, maker: bytes) -> PlainValue:
        return None if celsius(service, maker) is None else float(maker[at + 2] & 0x7F)

    return _SwitchbotRow("temperature", celsius), _SwitchbotRow("humidity", humidity)


def _carbon_dioxide(_service: bytes, maker: bytes) -> PlainValue:
    ppm = maker[13] << 8 | maker[14]
    return float(ppm) if ppm <= _MAX_PPM else None


def _tilt(_service: bytes, maker: bytes) -> PlainValue:
    return 100.0 - 2 * abs(_OPEN_TILT - min(maker[_BODY] & 0x7F, 100))


def _battery_at(at: int) -> _SwitchbotRow:
    return _SwitchbotRow("battery", lambda _service, maker: float(maker[at] & 0x7F))


def _lock(shift: int, mask: int) -> _SwitchbotRow:
    states = dict(enumerate(_LOCKS))
    return _SwitchbotRow("lock", lambda _service, maker: states.get((maker[7] & mask) >> shift), "door_lock")


_CLIMATE: Final = _climate_at(_BODY)
_CURTAIN: Final = _SwitchbotRow("position", lambda _, maker: 100.0 - min(maker[_BODY] & 0x7F, 100), "window_covering")
_BATTERY: Final = _SwitchbotRow("battery", lambda service, _: float(service[2] & 0x7F))
_PLUG: Final = (
    _SwitchbotRow("on_off", lambda _, maker: maker[7] == 0x80, "plug"),
    _SwitchbotRow("power", lambda _, maker: ((maker[10] & 0x7F) << 8 | maker[11]) / 10),
)
_RELAY: Final = _SwitchbotRow("on_off", lambda _, maker: bool(maker[7] & 0x80), "switch")
_WATTS: Final = _SwitchbotRow("power", lambda _, maker: float(maker[10] << 8 | maker[11]))
_LOCK_PRO: Final = (_lock(3, 0x78), *_bits(contact=(8, 0x10)), _battery_at(9))
_LOCK_LITE: Final = (_lock(4, 0x70), _BATTERY)
_BOT: Final = _SwitchbotRow("on_off", lambda service, _: (service[1] & 0xC0) == 0x80, "switch")
_MODELS: Final[Mapping[str, tuple[str, tuple[_SwitchbotRow, ...]]]] = {
    "TtIiWw4\x14": ("Meter", (*_CLIMATE, _BATTERY)),
    "5\x15": ("Meter Pro", (*_CLIMATE, _SwitchbotRow("carbon_dioxide", _carbon_dioxide), _BATTERY)),
    "Vv": ("Hub 2", _climate_at(13)),
    "%\x05": ("Hub Mini Matter", _climate_at(13)),
    "Dd": ("Contact Sensor", (*_bits(contact=(7, 0x30), occupancy=(7, 0x80), light_detected=(7, 0x40)), _BATTERY)),
    "Ss": ("Motion Sensor", (*_bits(occupancy=(7, 0x40), light_detected=(7, 0x20)), _BATTERY)),
    "&\x06": ("Leak Detector", (*_bits(water_leak=(8, 1), tamper=(8, 2)), _battery_at(7))),
    "Cc{[": ("Curtain", (_CURTAIN, _BATTERY)),
    ",\x0c": ("Roller Shade", (_CURTAIN, _BATTERY)),
    "Xx": ("Blind Tilt", (_SwitchbotRow("tilt", _tilt, "window_covering"), _BATTERY)),
    "GgJj": ("Plug Mini", _PLUG),
    "?\x1f": ("Plug Mini EU", (_RELAY._replace(service_type="plug"), _WATTS)),
    "<\x1c": ("Relay Switch 1PM", (_RELAY, _WATTS)),
    ";\x1b": ("Relay Switch 1", (_RELAY,)),
    "Oo": ("Lock", (_lock(4, 0x70), *_bits(contact=(7, 4)), _BATTERY)),
    "-\r": ("Lock Lite", _LOCK_LITE),
    "$\x04": ("Lock Pro", _LOCK_PRO),
    "H": ("Bot", (_BOT, _BATTERY)),
    ">\x1e": ("Garage Door Opener", (_SwitchbotRow("contact", lambda _, maker: not maker[7] & 0x20),)),
}
"""By the letters of each model, of which one is that of a device that is being paired."""

_NUMBERED: Final[Mapping[str, tuple[str, tuple[_SwitchbotRow, ...]]]] = {
    "10b940": ("Hub 3", (*_climate_at(13), *_bits(occupancy=(16, 0x80)))),
    "10a5b8": ("Lock Ultra", _LOCK_PRO),
    "10ff90": ("Lock Pro", _LOCK_PRO),  # with Wi-Fi
    "119fb8": ("Lock Ultra Max", _LOCK_PRO),
    "116909": ("Lock Vision Pro", _LOCK_PRO),
    "116908": ("Lock Vision", _LOCK_LITE),
    "10f3d8": ("Climate Panel", (*_climate_at(_BODY), *_bits(occupancy=(15, 0x80)), _battery_at(7))),
    "10ccc8": ("Presence Sensor", (*_bits(occupancy=(7, 0x40)), _BATTERY)),
    "1053b0": ("Weather Station", (*_climate_at(_BODY), _battery_at(7))),
}
"""By the number of each model without a letter, at the end of the data of its service or before their last byte."""

_MODEL_OF: Final = {
    **{letter.encode(): model for letters, model in _MODELS.items() for letter in letters},
    **{bytes.fromhex(number): model for number, model in _NUMBERED.items()},
}


class SwitchbotParser(BroadcastParser):
    """Reads the broadcasts of SwitchBot."""

    def __init__(self, bind_keys: Mapping[str, bytes]) -> None:
        super().__init__(bind_keys)
        self._last: dict[str, tuple[bytes, bytes]] = {}

    def concerns(self, advertisement: Advertisement) -> bool:
        """Return whether it is that of a known model."""
        service = _service_data(advertisement)
        return bool(service) and _model_of(service) is not None

    def read(self, advertisement: Advertisement, now: float) -> Broadcast | None:
        """Return the parts of a device, and its values if they are not the last ones again; None until all data came.

        Raises:
            WireError: It is truncated.
        """
        del now
        service, maker = _service_data(advertisement), advertisement.manufacturer_data.get(MAKER, b"")
        model, rows = _model_of(service) or ("", ())
        if len(maker) < _BODY + 3 and rows[0] in (*_CLIMATE, _CURTAIN):
            maker = bytes(_BODY) + service[3:]
        try:
            values = tuple(BroadcastValue(row.capability, row.capability, row.read(service, maker)) for row in rows)
        except IndexError:
            if MAKER not in advertisement.manufacturer_data:
                return None  # it comes in a packet of its own
            raise WireError("SwitchBot: it is cut off", service + maker) from None
        is_new = self._last.get(advertisement.address) != (service, maker)
        self._last[advertisement.address] = service, maker
        return Broadcast(
            name=f"{model} {advertisement.address[-5:].replace(':', '')}",  # they call themselves WoSensorTH
            parts=tuple(map(_part, rows)),
            values=values if is_new else (),
            metadata={"manufacturer": "SwitchBot", "model": model},
            silence=ON_BATTERY if any(row.capability == "battery" for row in rows) else 0.0,
        )

    def forget(self, address: str) -> None:
        """Forget a device."""
        self._last.pop(address, None)


def _service_data(advertisement: Advertisement) -> bytes:
    return next(
        (advertisement.service_data[service] for service in SERVICES if service in advertisement.service_data), b""
    )


def _model_of(service: bytes) -> tuple[str, tuple[_SwitchbotRow, ...]] | None:
    keys = bytes((service[0] & 0x7F,)), service[-3:], service[-4:-1]
    return next((_MODEL_OF[key] for key in keys if key in _MODEL_OF), None)


def _part(row: _SwitchbotRow) -> Part:
    category: Category = "diagnostic" if row.capability == "battery" else ""
    return sensor_part(row.capability, row.capability, service_type=row.service_type, category=category)
