"""Simulated bridges with their certificates, and the file of a pairing with one."""

import json
import ssl
from pathlib import Path

import trustme
from tests.integrations.hue.simulated.bridge import SimulatedHueBridge, make_certificate

KEY = "a-key-of-the-bridge"
BUTTONS = "device-of-buttons"
ABOUT = {
    "metadata": {"name": "Dimmer", "archetype": "unknown_archetype"},
    "product_data": {
        "model_id": "RWL022",
        "manufacturer_name": "homebot",
        "product_name": "Hue dimmer switch",
        "product_archetype": "unknown_archetype",
        "certified": True,
        "software_version": "2.45.2",
    },
}


def bridge_with_certificate(port: int = 0) -> tuple[SimulatedHueBridge, str]:
    """Return a bridge and its certificate, which an authority signed that no computer knows."""
    tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    return SimulatedHueBridge("home", tls, port=port), make_certificate("001788fffe123456", tls)


def self_signed(tls: ssl.SSLContext) -> str:
    """Make a certificate that the server signed itself, as the first bridges did, and return it."""
    authority = trustme.CA(organization_name="A bridge")
    with authority.private_key_pem.tempfile() as key, authority.cert_pem.tempfile() as certificate:
        tls.load_cert_chain(certificate, key)
    return authority.cert_pem.bytes().decode()


def pairings_of(bridge: SimulatedHueBridge, certificate: str, folder: Path) -> Path:
    """Pair homebot with a bridge that serves, and return the file of that."""
    bridge.keys.add(KEY)
    path = folder / "pairings.json"
    origin = f"https://{bridge.server.address}:{bridge.server.port}"
    path.touch(mode=0o600)
    path.write_text(
        json.dumps({bridge.id: {"name": "Hue bridge", "origin": origin, "key": KEY, "certificate": certificate}})
    )
    return path


def button(number: int) -> dict[str, object]:
    """Return a button of the dimmer."""
    owner = {"rid": BUTTONS, "rtype": "device"}
    events = ["initial_press", "repeat", "short_release", "long_release", "long_press"]
    metadata = {"control_id": number}
    return {
        "id": f"button-of-{number}",
        "type": "button",
        "owner": owner,
        "metadata": metadata,
        "button": {"event_values": events},
    }


def buttons(*services: dict[str, object]) -> list[dict[str, object]]:
    """Return the dimmer with its buttons."""
    listed = [{"rid": one["id"], "rtype": one["type"]} for one in services]
    return [
        {"id": BUTTONS, "type": "device", **ABOUT, "services": listed},
        *services,
    ]
