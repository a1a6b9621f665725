"""Simulated devices behind the Hue bridge of a house."""

from collections.abc import Callable, Mapping

from homebot.house.connected_device import HubDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.integrations.hue.formats.resources import at
from homebot.integrations.hue.simulated.bridge import SimulatedHueBridge
from homebot.integrations.hue.simulated.resources import (
    Resource,
    device_resources,
    light_orders,
    resource_uuid,
    state_fields,
)


class HueHouseDevice(HubDevice):
    """A lamp or sensor of the house in the radio network of a bridge.

    Args:
        kind: Its kind at the bridge, where it is another: ``plug`` for a lamp at a plug, ``gradient`` for one with
            several colours.
    """

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        bridge: SimulatedHueBridge,
        kind: str = "",
    ) -> None:
        super().__init__(device, on_command)
        self.kind = kind or device.kind
        self._bridge = bridge

    @property
    def owner_id(self) -> str:
        """The id of its device."""
        return resource_uuid(self.device.home, self.device.device_id)

    def resource_id(self, service: str) -> str:
        """Return the id of one of its services."""
        return resource_uuid(self.device.home, self.device.device_id, service)

    async def join(self) -> None:
        """Have the bridge reach it."""
        self._bridge.add(device_resources(self.device, self.kind, self.state), self, self.device.room)

    def leave(self) -> None:
        """Have the bridge miss it."""
        self._bridge.change(self.resource_id("zigbee_connectivity"), {"status": "connectivity_issue"})

    def show(self) -> None:
        """Report the fields that have changed."""
        if not self.is_there:
            return
        for rid, resource in tuple(self._bridge.resources.items()):
            owner = resource.get("owner")
            if isinstance(owner, dict) and owner.get("rid") == self.owner_id:
                service = str(resource["type"])
                fields = state_fields(service, self.kind, self.state)
                if service == "light" and self.kind != "plug":
                    now = self._bridge.resources[rid]["color_temperature"]
                    has_color = isinstance(now, dict) and now.get("mirek_valid") is False  # which no state tells
                    if has_color:
                        fields["color_temperature"] = now
                self._bridge.change(rid, fields)

    def obey(self, body: Mapping[str, object]) -> None:
        """Carry out a command to its light; the house knows nothing of colours and effects."""
        changed: Resource = {}
        points = at(body, "gradient", "points")
        color = at(points[0] if isinstance(points, list) and points else body, "color")
        if "gradient" in self._bridge.resources[self.resource_id("light")] and (color or "color_temperature" in body):
            changed["gradient"] = body.get("gradient", {"points": []})
        if color:
            changed |= {"color": color, "color_temperature": {"mirek": None, "mirek_valid": False}}
        elif "color_temperature" in body:
            changed["color_temperature"] = {"mirek_valid": True}
        if effect := at(body, "effects_v2", "action", "effect") or at(body, "effects", "effect"):
            changed |= {"effects": {"status": effect}, "effects_v2": {"status": {"effect": effect}}}
        self._bridge.change(self.resource_id("light"), changed)
        for order in light_orders(body):
            self.on_command(order)
