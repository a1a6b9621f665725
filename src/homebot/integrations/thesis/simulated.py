"""The layout of the thesis: reports and commands as plain text, on ``HOME/SERVICE_TYPE/DEVICE_ID/out`` and ``…/in``."""

from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo


class ThesisDialect(Dialect):
    """Every kind of device; the layout announces none."""

    announces = False
    kinds = frozenset(
        {
            "lamp",
            "window",
            "cover",
            "lock",
            "lift",
            "contact",
            "motion",
            "presence",
            "lux",
            "power_meter",
            "thermostat",
            "robot",
            "tag",
        }
    )
    """The kinds of :data:`homebot.house.kinds.KINDS`, which is loaded for described houses only."""

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return its ``in``."""
        return (f"{_base(device)}/in",)

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return the report on its ``out``; characters beyond Unicode become ``?``."""
        return (OutgoingMessage(f"{_base(device)}/out", state.text.encode(errors="replace")),)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the payload as text; invalid UTF-8 becomes U+FFFD."""
        del device, topic
        return (payload.decode(errors="replace"),)


def _base(device: SimulatedDeviceInfo) -> str:
    return f"{device.home}/{device.service_type}/{device.device_id}"
