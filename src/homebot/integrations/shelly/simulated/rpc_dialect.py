"""Shelly devices of the second generation and later: they describe themselves only when they are asked.

A device ``MODEL-mac`` takes calls on ``MODEL-mac/rpc``, answers on ``SRC/rpc``, with the caller's ``SRC``, publishes
changes on ``MODEL-mac/events/rpc``, and retains only ``MODEL-mac/online``.

Source: Shelly API documentation, Gen2, "MQTT" and "RPC protocol".
"""

from collections.abc import Mapping

from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.wire import as_json, as_object, device_orders, hardware_address, scaled

NOT_FOUND = 404
MODELS = {"lamp": "shellydimmerg3", "window": "shellyplus2pm", "cover": "shellyplus2pm"}
COMPONENTS = {"lamp": "light:0", "window": "cover:0", "cover": "cover:0"}


class ShellyRpcDialect(Dialect):
    """Lamps and motors with the topics that they have out of the box."""

    kinds = frozenset(MODELS)

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return where it takes calls."""
        return (f"{_id(device)}/rpc",)

    def availability(self, device: SimulatedDeviceInfo) -> tuple[str, bytes, bytes]:
        """Return the topic of its last will."""
        return f"{_id(device)}/online", b"true", b"false"

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its state, as news."""
        news = {
            "src": _id(device),
            "dst": f"{_id(device)}/events",
            "method": "NotifyStatus",
            "params": {"ts": 0.0, COMPONENTS[device.kind]: _status(device.kind, state)},
        }
        return (OutgoingMessage(f"{_id(device)}/events/rpc", as_json(news)),)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the command in a call."""
        del topic
        call = as_object(payload)
        given = call.get("params")
        wanted = given if isinstance(given, dict) else {}
        component, _, verb = str(call.get("method")).lower().partition(".")
        if component != COMPONENTS[device.kind].removesuffix(":0"):
            return ()
        is_set, is_on = verb in {"set", "gotoposition"}, wanted.get("on")
        return device_orders(
            device.kind,
            is_on=is_on if isinstance(is_on, bool) and is_set else None,
            brightness=scaled(wanted.get("brightness"), 100) if is_set else None,
            position=scaled(wanted.get("pos"), 100) if is_set else None,
            action=verb,
        )

    def replies(
        self, device: SimulatedDeviceInfo, state: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return the answer to a call; a call without ``src`` gets none."""
        del topic
        call = as_object(payload)
        caller = call.get("src")
        if not isinstance(caller, str) or not caller or any(sign in caller for sign in "+#\0"):
            return ()
        method = str(call.get("method"))
        own = COMPONENTS[device.kind]
        results: Mapping[str, object] = {
            "Shelly.GetDeviceInfo": describe_shelly(device),
            "Shelly.GetStatus": {own: _status(device.kind, state), "sys": {"mac": hardware_address(device).upper()}},
            "Shelly.GetComponents": {"components": [], "cfg_rev": 1, "offset": 0, "total": 0},
            "Shelly.GetConfig": {own: {"id": 0, "name": None}, "sys": {"device": {"name": device.device_id}}},
        }
        answer: dict[str, object] = {"id": call.get("id"), "src": _id(device), "dst": caller}
        if method in results:
            answer["result"] = results[method]
        elif method.lower().startswith(own.removesuffix("0").replace(":", ".")):
            answer["result"] = None
        else:
            answer["error"] = {"code": NOT_FOUND, "message": f"No handler for {method[:100]}"}
        return (OutgoingMessage(f"{caller[:200]}/rpc", as_json(answer)),)


def _id(device: SimulatedDeviceInfo) -> str:
    return f"{MODELS[device.kind]}-{hardware_address(device)}"


def describe_shelly(device: SimulatedDeviceInfo) -> dict[str, object]:
    """Return the device information of *device*."""
    model = MODELS[device.kind]
    return {
        "name": device.device_id,
        "id": _id(device),
        "mac": hardware_address(device).upper(),
        "model": model,
        "gen": 3 if device.kind == "lamp" else 2,
        "fw_id": "20241011-114449/1.4.4-g6d2a586",
        "ver": "1.4.4",
        "app": model,
        "auth_en": False,
        "auth_domain": None,
        **({} if device.kind == "lamp" else {"profile": "cover"}),
    }


def _status(kind: str, state: DeviceState) -> dict[str, object]:
    if kind == "lamp":
        brightness = round(state.brightness * 100)
        return {"id": 0, "source": "mqtt", "output": state.is_on, "brightness": brightness}
    rests = "open" if state.position else "closed"
    text = {1: "opening", -1: "closing"}.get(state.way, rests)
    return {"id": 0, "state": text, "pos_control": True, "current_pos": round(state.position * 100)}
