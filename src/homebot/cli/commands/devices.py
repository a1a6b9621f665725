"""``homebot devices``."""

from __future__ import annotations

import argparse
import json
from datetime import UTC, datetime

from pydantic import BaseModel

from homebot.cli.door_client import DoorClient
from homebot.cli.table import to_table
from homebot.cli.through_door import through_door
from homebot.devices import FIND_DEVICES

__all__ = ["list_devices"]

_HEAD = ("DEVICE", "TYPE", "GATEWAY", "ADDRESS", "STATE", "LAST SEEN")
_SPANS = ((86_400, "d"), (3600, "h"), (60, "min"), (1, "s"))


class _Time(BaseModel):
    sec: int
    nanosec: int

    @property
    def seconds(self) -> float:
        return self.sec + self.nanosec / 1e9

    @property
    def iso(self) -> str:
        moment = datetime.fromtimestamp(self.sec, UTC).replace(microsecond=self.nanosec // 1000)
        return moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")


class _Endpoint(BaseModel):
    gateway: str
    key: str
    address: str
    command_address: str


class _KeyValue(BaseModel):
    key: str
    value: str


class _Device(BaseModel):
    id: str
    name: str
    service_type: str
    endpoints: list[_Endpoint]
    metadata: list[_KeyValue]
    first_seen: _Time
    last_seen: _Time
    expires: _Time
    freshness: str

    def to_json(self) -> dict[str, object]:
        first = self.endpoints[0] if self.endpoints else None
        return {
            "id": self.id,
            "name": self.name,
            "service_type": self.service_type,
            "gateway": first.gateway if first else "",
            "address": first.address if first else "",
            "first_seen": self.first_seen.iso,
            "last_seen": self.last_seen.iso,
            "expires": self.expires.iso,
            "freshness": self.freshness,
            "endpoints": [one.model_dump() for one in self.endpoints],
            "metadata": {one.key: one.value for one in self.metadata},
        }

    def to_row(self, now: float) -> tuple[str, ...]:
        first = self.endpoints[0] if self.endpoints else None
        ago = _ago(now - self.last_seen.seconds)
        where = (first.gateway, first.address) if first else ("", "")
        return (self.id, self.service_type, *where, self.freshness, ago)


class _Answer(BaseModel):
    devices: list[_Device]


class _Now(BaseModel):
    time: _Time


def list_devices(options: argparse.Namespace) -> int:
    """Print the devices as a table, or as a JSON list."""

    async def run(door: DoorClient) -> int:
        answer = _Answer.model_validate(await door.call(FIND_DEVICES, {"service_type": options.type}))
        if options.json:
            print(json.dumps([one.to_json() for one in answer.devices], indent=2))
        elif not answer.devices:
            print(f"no device offers {options.type} now" if options.type else "no device was discovered yet")
        else:
            now = _Now.model_validate(await door.call("/rosapi/get_time")).time.seconds
            print(to_table(_HEAD, [one.to_row(now) for one in answer.devices]))
        return 0

    return through_door(options, run)


def _ago(seconds: float) -> str:
    for size, unit in _SPANS:
        if seconds >= size:
            return f"{seconds / size:.0f} {unit} ago"
    return "now"
