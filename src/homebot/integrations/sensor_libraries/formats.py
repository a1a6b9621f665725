"""Parser of sensors through the libraries for their formats: xiaomi-ble, govee-ble, ruuvitag-ble and so on. Pure.

These libraries share a base, ``bluetooth-sensor-state-data``: a class that takes advertisements and returns values with
Home Assistant's device classes and units. All that are installed are used; ``homebot[ble-sensors]`` installs some.
Values that a library would read over a connection, as some do, are not read.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from decimal import Decimal
from functools import cache
from importlib.metadata import distributions
from typing import TYPE_CHECKING

from homebot.conventions.bluetooth.broadcast import (
    Advertisement,
    Broadcast,
    BroadcastParser,
    BroadcastValue,
    sensor_part,
)
from homebot.conventions.description import AutoExpiry
from homebot.conventions.device_classes import condition_of, quantity_of
from homebot.conventions.units import Quantity, sensor_type
from homebot.devices.part import Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import PluginError, WireError

if TYPE_CHECKING:
    from bluetooth_sensor_state_data import BluetoothData
    from habluetooth import BluetoothServiceInfoBleak
    from sensor_state_data import DeviceKey, Event, SensorDescription, SensorUpdate

BASE = "bluetooth-sensor-state-data"
ON_BATTERY = 300.0
"""Seconds for which a battery-powered device may be silent."""

MAX_PARTS = 64
_OWN_CLASSES = frozenset({"signal_strength", "packet_id"})
_HOME_ASSISTANT: Mapping[str, str] = {"dew_point": "temperature"}
"""Its class for one that the libraries alone have."""

_PRESSES: Mapping[str, str] = {
    "press": "single",
    "double_press": "double",
    "triple_press": "triple",
    "long_press": "long",
}
"""Events of buttons in the words of the vocabulary; others, such as ``rotate_left``, stay as they are."""

_BUTTONS = frozenset({"button", "cube", "dimmer"})
_OCCUPANCY_IS_A_BUTTON = frozenset({"mopeka_iot_ble", "thermobeacon_ble"})
"""Libraries that report a pressed button as ``occupancy``, which would say that nobody is in the room."""

_MOMENTS = frozenset({"motion", "vibration"})
"""States that an event reports, by the first word of its key; no event reports their end (Govee H5121 and H5124, Xiaomi
MUE4094RT)."""

MOMENT = 90.0
"""Seconds after which it is unknown again: the value in Zigbee2MQTT for motion sensors that do not report it either."""


class _Sensor:
    def __init__(self, reader: BluetoothData) -> None:
        self.reader = reader
        self.parts: dict[str, Part] = {}
        self.values: dict[int, object] = {}  # by identity: each packet makes those that it has anew
        self.moments: set[str] = set()
        self.last: Advertisement | None = None

    def expiries(self) -> dict[str, tuple[AutoExpiry, ...]]:
        moments = [part for part in self.parts.values() if part.id in self.moments]
        return {moment.id: (AutoExpiry(moment.capabilities[0].name, MOMENT),) for moment in moments}


class SensorLibraryParser(BroadcastParser):
    """Reads the broadcasts that any installed library of this family supports.

    Args:
        libraries: The classes that read advertisements; by default those of all installed libraries.

    Raises:
        PluginError: An installed library cannot be imported.
    """

    def __init__(self, bind_keys: Mapping[str, bytes], libraries: Sequence[type[BluetoothData]] | None = None) -> None:
        super().__init__(bind_keys)
        self._libraries = _libraries() if libraries is None else libraries
        self._sensors: dict[str, _Sensor] = {}

    def concerns(self, advertisement: Advertisement) -> bool:
        """Return whether it has data, and there is a library that might read them."""
        return bool(self._libraries and (advertisement.manufacturer_data or advertisement.service_data))

    def read(self, advertisement: Advertisement, now: float) -> Broadcast | None:
        """Return all parts that are known, and the values of an advertisement that is new; None if no library reads it.

        Raises:
            WireError: A library failed at it.
        """
        del now
        info = _service_info(advertisement)
        sensor = self._sensors.get(advertisement.address) or self._find(advertisement, info)
        if sensor is None:
            return None
        self._sensors[advertisement.address] = sensor
        is_new = sensor.last is None or not sensor.last.says_the_same(advertisement)
        sensor.last = advertisement
        try:
            update = sensor.reader.update(info)
        except Exception as exc:
            raise _unreadable(sensor.reader, advertisement, exc) from exc
        values = tuple(_read_update(sensor, update))
        scheme = getattr(getattr(sensor.reader, "encryption_scheme", None), "name", "NONE")
        problem = ""  # by attributes that the libraries for devices that encrypt share
        if scheme != "NONE" and not getattr(sensor.reader, "bindkey_verified", True):
            problem = "it is encrypted with another bind key"
            if getattr(sensor.reader, "bindkey", None) is None:
                problem = "it is encrypted, and no bind key is configured for it"
        facts: dict[str, str | None] = {}
        if about := next(iter(update.devices.values()), None):  # the device itself, not probes at it
            facts = {"manufacturer": about.manufacturer, "model": about.model, "firmware": about.sw_version}
        return Broadcast(
            name=update.title or _name_of(update) or advertisement.name,
            parts=tuple(sensor.parts.values()),
            values=values if is_new else (),
            expiries=sensor.expiries(),
            metadata={name: str(fact) for name, fact in facts.items() if fact},
            silence=ON_BATTERY if any("battery" in part for part in sensor.parts) else 0.0,
            problem=problem,
        )

    def forget(self, address: str) -> None:
        """Forget a device."""
        self._sensors.pop(address, None)

    def _find(self, advertisement: Advertisement, info: BluetoothServiceInfoBleak) -> _Sensor | None:
        """Return the sensor of the first library that supports an advertisement.

        Raises:
            WireError: None does, and one failed at it.
        """
        failure: WireError | None = None
        for library in self._libraries:
            try:
                # Another instance reads it then: one that has seen a packet takes it for a copy.
                if self._new(library, advertisement.address).supported(info):
                    return _Sensor(self._new(library, advertisement.address))
            except Exception as exc:  # noqa: BLE001 - code of others, with data of strangers
                failure = failure or _unreadable(library, advertisement, exc)
        if failure is not None:
            raise failure
        return None

    def _new(self, library: type[BluetoothData], address: str) -> BluetoothData:
        key = self.bind_keys.get(address)
        if key is not None and "bindkey" in inspect.signature(library).parameters:
            return library(bindkey=key)  # type: ignore[call-arg] # as just checked
        return library()


@cache
def _libraries() -> tuple[type[BluetoothData], ...]:
    """Return the parsers of all installed libraries, in the order of their names.

    Raises:
        PluginError: One cannot be imported.
    """
    if importlib.util.find_spec("bluetooth_sensor_state_data") is None:
        return ()
    from bluetooth_sensor_state_data import BluetoothData  # noqa: PLC0415 - an extra

    names: set[str] = set()
    for distribution in distributions():
        name = (distribution.name or "").lower()
        if name.endswith("-ble") and any(requirement.startswith(BASE) for requirement in distribution.requires or ()):
            names.add(name)
    libraries: list[type[BluetoothData]] = []
    for name in sorted(names):
        try:
            module = importlib.import_module(name.replace("-", "_"))
        except Exception as exc:
            raise PluginError(name, f"cannot be imported: {str(exc)[:200]}") from exc
        libraries += [
            member
            for member in vars(module).values()
            if isinstance(member, type) and issubclass(member, BluetoothData) and member is not BluetoothData
        ]
    return tuple(libraries)


def _service_info(advertisement: Advertisement) -> BluetoothServiceInfoBleak:
    from habluetooth import BluetoothServiceInfoBleak  # noqa: PLC0415 - an extra

    return BluetoothServiceInfoBleak(
        name=advertisement.name or advertisement.address,
        address=advertisement.address,
        rssi=advertisement.rssi,
        manufacturer_data=dict(advertisement.manufacturer_data),
        service_data=dict(advertisement.service_data),
        service_uuids=list(advertisement.service_uuids),
        source="homebot",
        device=None,  # type: ignore[arg-type] # for connections, which are not made
        advertisement=None,
        connectable=False,
        time=0.0,
        tx_power=advertisement.tx_power,
    )


def _read_update(sensor: _Sensor, update: SensorUpdate) -> Iterator[BroadcastValue]:
    """Add the parts of an update, and yield the values of its packet: an update has all values so far."""
    parts, before = sensor.parts, sensor.values
    sensor.values = {
        id(value): value for value in (*update.entity_values.values(), *update.binary_entity_values.values())
    }
    for key, measured in update.entity_values.items():
        description = update.entity_descriptions[key]
        device_class = str(getattr(description.device_class, "value", "") or "")
        if device_class not in _OWN_CLASSES and id(measured) not in before:
            yield from _read_measurement(parts, _part_id(key), description, device_class, measured.native_value)
    for key, value in update.binary_entity_values.items():
        if id(value) not in before:
            yield from _condition(sensor, key, update.binary_entity_descriptions[key].device_class, value.native_value)
    for key, event in update.events.items():
        yield from _read_event(sensor, _part_id(key), event)


def _condition(sensor: _Sensor, key: DeviceKey, described: object, value: object) -> Iterator[BroadcastValue]:
    device_class = str(getattr(described, "value", "") or "")
    is_button = device_class == "occupancy" and _package_of(type(sensor.reader)) in _OCCUPANCY_IS_A_BUTTON
    service_type, capability = condition_of("" if is_button else device_class)
    part = sensor_part("button" if is_button else _part_id(key), capability, service_type=service_type)
    if _has(sensor.parts, part):
        yield BroadcastValue(part.id, capability, None if value is None else bool(value))


def _read_event(sensor: _Sensor, part_id: str, event: Event) -> Iterator[BroadcastValue]:
    """Add the part of an event, and yield its value: a press, a condition for a moment, or the event in its words.

    The last is of a part of its own: a lock has a state of the same name.
    """
    kind, value = part_id.partition("_")[0], _PRESSES.get(event.event_type, event.event_type[:_MAX_EVENT_CHARACTERS])
    service_type, capability = "", "press"
    if kind in _MOMENTS:
        service_type, capability = condition_of(kind)
        sensor.moments.add(part_id)
    elif kind not in _BUTTONS:
        service_type, part_id = sensor_type("value"), f"{part_id}_event"
    steps = (event.event_properties or {}).get("steps")
    if _has(sensor.parts, sensor_part(part_id, capability, service_type=service_type)):
        said = value if steps is None else f"{value} {steps}"
        yield BroadcastValue(part_id, capability, True if kind in _MOMENTS else said)


_MAX_EVENT_CHARACTERS = 100


def _read_measurement(
    parts: dict[str, Part], part_id: str, description: SensorDescription, device_class: str, value: object
) -> Iterator[BroadcastValue]:
    unit = str(description.native_unit_of_measurement or "")
    known = quantity_of(_HOME_ASSISTANT.get(device_class, device_class), unit)
    quantity = Quantity(known.service_type, "measurement") if known.unit and not unit else known
    is_aside = device_class in {"battery", "voltage"} or "_alarm_" in part_id  # the limits of a Govee H5055, in °C
    category: Category = "diagnostic" if is_aside else ""
    is_text = isinstance(value, str | date) and not unit  # a Govee reports "error" in °C
    if is_text:
        part = sensor_part(part_id, "value", category=category)
    else:
        part = sensor_part(
            part_id, quantity.capability, unit=quantity.unit, service_type=quantity.service_type, category=category
        )
    if not _has(parts, part):
        return
    value_read: PlainValue = None
    if is_text:
        value_read = value.isoformat() if isinstance(value, date) else str(value)[:200]
    elif isinstance(value, int | float | Decimal):
        value_read = quantity.value(float(value))
    yield BroadcastValue(part_id, part.capabilities[0].name, value_read)


def _has(parts: dict[str, Part], part: Part) -> bool:
    """Return whether *parts* has this part, which is added if it is new and there is room."""
    if part.id not in parts and len(parts) < MAX_PARTS:
        parts[part.id] = part
    known = parts.get(part.id)
    return known is not None and known.capabilities == part.capabilities


def _part_id(key: DeviceKey) -> str:
    key_of_value: object = key.key  # some are members of an enumeration, and Qingping has (None, "door_left_open")
    name = str(key_of_value[-1] if isinstance(key_of_value, tuple) else key_of_value)
    return name if key.device_id is None else f"{key.device_id}_{name}"


def _name_of(update: SensorUpdate) -> str:
    """Return the name that a library without titles gives the device: ``RuuviTag EFAF``, ``IBS-TH EEFF``."""
    return next((device.name for device in update.devices.values() if device.name), "")


def _unreadable(
    library: BluetoothData | type[BluetoothData], advertisement: Advertisement, error: Exception
) -> WireError:
    kind = library if isinstance(library, type) else type(library)
    data = next(iter((*advertisement.manufacturer_data.values(), *advertisement.service_data.values())), b"")
    return WireError(f"{_package_of(kind)} cannot read it: {type(error).__name__}", data)


def _package_of(library: type[BluetoothData]) -> str:
    return library.__module__.partition(".")[0]
