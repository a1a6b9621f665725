"""A robot that holds a door open through homebot's door, for ever: to be killed.

``python holding_robot.py URL TOKEN DEVICE PART NAME TTL`` prints ``held`` once it holds the device.
"""

import json
import sys
import time

from websockets.sync.client import ClientConnection, connect

TOLD = 60.0


def call(peer: ClientConnection, service: str, arguments: dict[str, object]) -> bool:
    """Call a service of leases; return whether the lease is held."""
    peer.send(json.dumps({"op": "call_service", "id": "x", "service": service, "args": arguments, "timeout": TOLD}))
    while (frame := json.loads(peer.recv(timeout=TOLD))).get("id") != "x":
        pass
    return bool(frame["values"]["held"])


def main() -> None:
    """Hold, and renew until killed."""
    url, token, device, part, name, ttl = sys.argv[1:]
    key: dict[str, object] = {"lease": name, "by": name, "issuer": ""}
    setting = {"capability": "movement", "value": {"type": 3, "text": "open"}}
    wanted = {"device": device, "part": part, "setting": setting}
    with connect(url, additional_headers={"Authorization": f"Bearer {token}"}, proxy=None) as peer:
        print("held" if call(peer, "/control/hold", {**key, **wanted, "ttl": float(ttl)}) else "refused", flush=True)
        while call(peer, "/control/renew", key):
            time.sleep(float(ttl) / 10)


if __name__ == "__main__":
    main()
