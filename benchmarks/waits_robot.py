"""A robot on Zenoh that asks for all devices: ``python waits_robot.py ADDRESS NAME SECRET``.

Each client of it has an id of its own, as those of several programs.
"""

from __future__ import annotations

import json
import os
import sys
from functools import partial
from queue import SimpleQueue
from typing import Any

import zenoh

from homebot.bridges.zenoh.attachment import Attachment
from homebot.bridges.zenoh.tokens import data_key
from homebot.devices.services import QueryDevices, QueryDevicesRequest, QueryDevicesResponse
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.type_hash import type_hash

__all__: list[str] = []

LONGEST = 30.0  # s


def main(address: str, name: str, secret: str) -> None:
    config = {
        "mode": "client",
        "connect": {"endpoints": [address], "timeout_ms": 30_000},
        "scouting": {"multicast": {"enabled": False}},
        "transport": {"auth": {"usrpwd": {"user": name, "password": secret}}},
    }
    key = data_key(0, "/discovery/query", QueryDevices.ros_type, type_hash(QueryDevices))
    request = message_to_cdr(QueryDevicesRequest(query=()))
    with zenoh.open(zenoh.Config.from_json5(json.dumps(config))) as session:
        print(json.dumps({"pid": os.getpid()}), flush=True)
        for line in sys.stdin:
            count = json.loads(line)["count"]
            answers: list[bytes] = []
            ends: SimpleQueue[None] = SimpleQueue()

            def replied(reply: Any, answers: list[bytes] = answers) -> None:
                answers.append(b"" if reply.ok is None else bytes(reply.ok.payload))

            for number in range(count):
                attachment = Attachment(number, 0, number.to_bytes(16, "little")).to_bytes()
                handler = zenoh.handlers.Callback(replied, partial(ends.put, None))
                session.get(key, handler, payload=request, attachment=attachment, timeout=LONGEST)
            for _ in range(count):
                ends.get()
            print(json.dumps({"devices": [_devices(answer) for answer in answers]}), flush=True)


def _devices(answer: bytes) -> int:
    return len(message_from_cdr(QueryDevicesResponse, answer).results) if answer else 0


if __name__ == "__main__":
    main(*sys.argv[1:])
