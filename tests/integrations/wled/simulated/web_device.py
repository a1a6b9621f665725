"""Light strips with WLED: the JSON API over HTTP, and pushes over a WebSocket.

Source: WLED 0.15, https://kno.wled.ge/interfaces/json-api and /websocket.
"""

from collections.abc import Callable, Mapping

from tests.simulated.dns_sd import DnsSdService
from tests.simulated.http.served_web_device import ServedWebDevice
from tests.simulated.http.web_server import WebPeer, WebReply, WebRequest

from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.wire import as_json, hardware_address, json_value, lamp_order, scaled
from homebot.support.numbers import to_number

EFFECTS = ("Solid", "Blink", "Breathe", "Wipe", "RSVD", "Rainbow")
PALETTES = ("Default", "* Random Cycle")
FULL = 255
WARMEST, STEP = 1900, 32
RGB_AND_WHITES = 5


class ServedWled(ServedWebDevice):
    """One lamp: a strip with a single segment, with colours and whites.

    Attributes:
        is_live: Whether another program lights it.
        segment: The colours and the effect, as the state says them.
        sync: Whether it sends its state to others, and takes theirs.
        presets: Its presets, by number as text.
        preset: The number of the preset that was chosen last; -1 for none.
    """

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        *,
        address: str = "127.0.0.1",
        port: int = 0,
        announced: bool = False,
    ) -> None:
        super().__init__(device, on_command, address=address, port=port, announced=announced)
        self.is_live = False
        self.segment: dict[str, object] = {"col": [[255, 160, 0], [0, 0, 0], [0, 0, 0]], "fx": 0, "sx": 128, "ix": 128}
        self.sync = {"send": False, "recv": True}
        self.night_light = {"on": False, "dur": 60, "mode": 1, "tbri": 0, "rem": -1}
        self.presets: dict[str, object] = {"0": {}}
        self.preset = -1

    @property
    def mac(self) -> str:
        """Its hardware address."""
        return hardware_address(self.device)

    def service(self) -> DnsSdService:
        """Return its announced service."""
        host = f"wled-{self.mac[-6:]}"
        return DnsSdService("_wled._tcp.local.", host, host, self.server.port, {"mac": self.mac})

    def show(self) -> None:
        """Send everything to every WebSocket."""
        self.server.broadcast(self._state_and_info())

    def answer(self, request: WebRequest) -> WebReply:
        """Return the answer to a request of HTTP."""
        path = request.path.rstrip("/")
        if request.method == "POST" and path in {"/json", "/json/state", "/json/si"}:
            wanted = json_value(request.body)
            if not isinstance(wanted, dict):
                return WebReply(b'{"error":9}', 400)
            if not self._apply(wanted):
                return WebReply(b'{"success":true}')
            return WebReply(as_json(self._state() if path == "/json/state" else self._everything()))
        documents: Mapping[str, Callable[[], object]] = {
            "/json": lambda: self._everything() | {"effects": EFFECTS, "palettes": PALETTES},
            "/json/si": self._everything,
            "/json/state": self._state,
            "/json/info": self._info,
            "/json/eff": lambda: EFFECTS,
            "/json/fxdata": lambda: [""] * len(EFFECTS),
            "/json/pal": lambda: PALETTES,
            "/json/cfg": dict,
            "/presets.json": lambda: self.presets,
        }
        if path in documents:
            return WebReply(as_json(documents[path]()))
        return WebReply(b"Not found", 404, "text/plain")

    def greet(self, peer: WebPeer, path: str) -> bool:
        """Accept a WebSocket to ``/ws``, and send it everything."""
        if path == "/ws":
            peer.send(self._state_and_info())
        return path == "/ws"

    def receive(self, peer: WebPeer, message: bytes) -> None:
        """Apply a state from a WebSocket."""
        peer.send(self._state_and_info() if self._apply(json_value(message)) else b'{"success":true}')

    def _apply(self, wanted: object) -> bool:
        """Apply a state, and return whether the answer is the whole state."""
        if not isinstance(wanted, dict):
            return False
        listed = wanted.get("seg")
        first = listed[0] if isinstance(listed, list) and listed else listed
        segment = first if isinstance(first, dict) else {}
        if isinstance(chosen := wanted.get("ps"), int):
            self.preset = chosen
        self.segment |= {name: segment[name] for name in ("col", "fx", "sx", "ix") if name in segment}
        for own, given in ((self.sync, wanted.get("udpn")), (self.night_light, wanted.get("nl"))):
            if isinstance(given, dict):
                own.update({name: value for name, value in given.items() if name in own})
        is_on = not self.state.is_on if wanted.get("on") == "t" else wanted.get("on")
        steps = to_number(segment.get("cct"))
        for command in lamp_order(
            is_on=is_on if isinstance(is_on, bool) else None,
            brightness=scaled(wanted.get("bri"), FULL),
            kelvin=steps if steps is None or steps > FULL else WARMEST + STEP * steps,
        ):
            self.on_command(command)
        self.show()
        return wanted.get("v") is True

    def _state_and_info(self) -> bytes:
        return as_json(self._everything())

    def _everything(self) -> dict[str, object]:
        return {"state": self._state(), "info": self._info()}

    def _state(self) -> dict[str, object]:
        steps = round((self.state.kelvin - WARMEST) / STEP)
        return {
            "on": self.state.is_on,
            "bri": max(1, round(self.state.brightness * FULL)),
            "transition": 7,
            "ps": self.preset,
            "pl": -1,
            "nl": self.night_light,
            "udpn": self.sync,
            "lor": 0,
            "mainseg": 0,
            "seg": [
                {
                    "id": 0,
                    "start": 0,
                    "stop": 30,
                    "len": 30,
                    "grp": 1,
                    "spc": 0,
                    "of": 0,
                    "on": True,
                    "frz": False,
                    "bri": FULL,
                    "cct": min(max(steps, 0), FULL),
                    "pal": 0,
                    "sel": True,
                    "rev": False,
                    "mi": False,
                    **self.segment,
                }
            ],
        }

    def _info(self) -> dict[str, object]:
        return {
            "ver": "0.15.0",
            "vid": 2412100,
            "leds": {
                "count": 30,
                "pwr": 470,
                "fps": 42,
                "maxpwr": 850,
                "maxseg": 32,
                "seglc": [RGB_AND_WHITES],
                "lc": RGB_AND_WHITES,
                "rgbw": False,
                "wv": 0,
                "cct": 4,
            },
            "str": False,
            "name": self.device.device_id,
            "udpport": 21324,
            "live": self.is_live,
            "liveseg": -1,
            "lm": "",
            "lip": "",
            "ws": len(self.server.peers),
            "fxcount": len(EFFECTS),
            "palcount": len(PALETTES),
            "wifi": {"bssid": "02:00:00:00:00:01", "rssi": -62, "signal": 76, "channel": 6},
            "fs": {"u": 12, "t": 983, "pmt": len(self.presets)},
            "ndc": 0,
            "arch": "esp32",
            "core": "v3.3.6-16-gcc5440f6a2",
            "lwip": 0,
            "freeheap": 208000,
            "uptime": 1000,
            "opt": 79,
            "brand": "WLED",
            "product": "FOSS",
            "mac": self.mac,
            "ip": self.server.address,
        }
