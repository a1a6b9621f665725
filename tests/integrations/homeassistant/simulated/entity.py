"""The entities of simulated devices, as a simulated Home Assistant has them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import anyio
from anyio.abc import TaskStatus
from tests.integrations.homeassistant.simulated.server import Fields, ListedEntity, SimulatedHomeAssistant

from homebot.devices.identity import in_pairs
from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.wire import device_orders, hardware_address, node_name, scaled
from homebot.support.numbers import to_number

_LEVELS: Final = 255


@dataclass(frozen=True, slots=True)
class ServedEntityKind:
    """The entity of one kind of devices.

    Attributes:
        state: Returns its state and its attributes.
        fixed: Attributes that never change.
    """

    domain: str
    state: Callable[[DeviceState], tuple[str, Fields]]
    fixed: Fields


def _lamp(lamp: DeviceState) -> tuple[str, Fields]:
    if not lamp.is_on:
        return "off", {"color_mode": None, "brightness": None, "color_temp_kelvin": None}
    level = max(1, round(lamp.brightness * _LEVELS))
    return "on", {"color_mode": "color_temp", "brightness": level, "color_temp_kelvin": round(lamp.kelvin)}


def _motor(motor: DeviceState) -> tuple[str, Fields]:
    rests = "open" if motor.position else "closed"
    return {1: "opening", -1: "closing"}.get(motor.way, rests), {"current_position": round(motor.position * 100)}


def _thermostat(thermostat: DeviceState) -> tuple[str, Fields]:
    return "heat", {
        "current_temperature": round(thermostat.celsius, 1),
        "temperature": round(thermostat.target, 3),
        "hvac_action": "heating" if thermostat.heats else "idle",
    }


def _cover(device_class: str) -> ServedEntityKind:
    return ServedEntityKind("cover", _motor, {"device_class": device_class, "supported_features": 15})


def _sensor(device_class: str, unit: str) -> ServedEntityKind:
    fixed = {"device_class": device_class, "unit_of_measurement": unit, "state_class": "measurement"}
    return ServedEntityKind("sensor", lambda state: (f"{state.value:g}", {}), fixed)


def _binary(device_class: str, on: str) -> ServedEntityKind:
    fixed = {"device_class": device_class}
    return ServedEntityKind("binary_sensor", lambda state: ("on" if state.text == on else "off", {}), fixed)


_LIGHT: Final = {
    "supported_color_modes": ["color_temp"],
    "min_color_temp_kelvin": 1500,
    "max_color_temp_kelvin": 8929,
    "supported_features": 0,
}
_CLIMATE: Final = {"hvac_modes": ["heat"], "min_temp": 5, "max_temp": 30, "supported_features": 1}

TEMPLATES: Final[Mapping[str, ServedEntityKind]] = {
    "lamp": ServedEntityKind("light", _lamp, _LIGHT),
    "window": _cover("window"),
    "cover": _cover("shutter"),
    "lock": ServedEntityKind("lock", lambda lock: (lock.text, {}), {"supported_features": 0}),
    "contact": _binary("door", "open"),
    "motion": _binary("motion", "motion"),
    "lux": _sensor("illuminance", "lx"),
    "power_meter": _sensor("power", "W"),
    "thermostat": ServedEntityKind("climate", _thermostat, _CLIMATE),
}
"""By kind."""

_ACTIONS: Final[Mapping[str, str]] = {
    **{f"{action}_cover": action for action in ("open", "close", "stop")},
    "lock": "lock",
    "unlock": "unlock",
}
_NUMBERS: Final = {"set_cover_position": "position", "set_temperature": "temperature"}


class ServedEntity(ServedDevice, ListedEntity):
    """A lamp, window, cover, lock, thermostat or sensor as an entity of a Home Assistant."""

    def __init__(
        self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], server: SimulatedHomeAssistant
    ) -> None:
        ServedDevice.__init__(self, device, on_command)
        self.shown = "unavailable"
        self.attributes: dict[str, object] = {}
        self.server = server
        self.template = TEMPLATES[device.kind]
        self.entity_id = f"{self.template.domain}.{node_name(device).replace('-', '_').lower()}"
        self._is_there = False

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Be available until cancelled."""
        self._is_there = True
        self.shown, attributes = self.template.state(self.state)
        self.attributes = {**self.template.fixed, **attributes, "friendly_name": self.device.device_id}
        self.server.reach(self, self.device.room)
        task_status.started()
        try:
            await anyio.sleep_forever()
        finally:
            self._is_there = False
            self.server.show(self, "unavailable", {})

    def show(self) -> None:
        """Report the new state."""
        if self._is_there:
            self.server.show(self, *self.template.state(self.state))

    def call(self, service: str, data: Fields) -> bool:
        """Carry out a service; return false for one that it does not have."""
        orders = self.orders(service, data)
        for order in orders:
            self.on_command(order)
        return bool(orders)

    def orders(self, service: str, data: Fields) -> tuple[str, ...]:
        """Return the orders of a service; none for one that it does not have."""
        number = to_number(data.get(_NUMBERS.get(service, "")))
        return device_orders(
            self.device.kind,
            is_on={"turn_on": True, "turn_off": False}.get(service),
            brightness=scaled(data.get("brightness"), _LEVELS),
            kelvin=to_number(data.get("color_temp_kelvin")),
            position=None if number is None else number / 100,
            action=_ACTIONS.get(service, ""),
            target=number,
        )

    def entry(self) -> Fields:
        """Return its entry in the registry of entities."""
        node = node_name(self.device)
        return {
            "id": hardware_address(self.device, 32),
            "unique_id": node,
            "device_id": node,
            "platform": "simulated",
            "name": None,
            "original_name": None,
            "entity_category": None,
            "hidden_by": None,
            "disabled_by": None,
            "labels": [],
        }

    def device_entry(self) -> Fields:
        """Return the entry of its device."""
        return {
            "id": node_name(self.device),
            "name": self.device.device_id,
            "area_id": self.device.room,
            "manufacturer": "homebot",
            "model": f"simulated {self.device.kind}",
            "identifiers": [["simulated", node_name(self.device)]],
            "connections": [["mac", in_pairs(hardware_address(self.device))]],
            "disabled_by": None,
        }
