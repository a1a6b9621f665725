"""Damaged messages of a Matter server: refused in our words, or understood."""

import json
import random
from collections.abc import Mapping
from contextlib import suppress

from tests.fuzz.conftest import Fuzz
from tests.gateways.checked_command import checked_command
from tests.integrations.matter.simulated.clusters import DEVICE_TYPES, attributes_of

from homebot.conventions.capability_row import writer_of
from homebot.conventions.payload import as_fields, parse_json
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.announced.gateway_device import can_report
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.matter.formats.sensor_clusters import press_of
from homebot.integrations.matter.gateway.node import MatterNode, NodeDevice, parse_path
from homebot.integrations.matter.gateway.server_link import MAX_FRAME_BYTES, check_greeting, result_of

STATE = DeviceState(text="on", is_on=True, value=5.0)
NODES = tuple(attributes_of(SimulatedDeviceInfo("home", kind, "x", "x", "hall"), STATE) for kind in DEVICE_TYPES)
CLUSTERS = (3, 6, 8, 29, 40, 47, 51, 57, 59, 64, 65, 69, 80, 84, 91, 92, 96, 97, 129, 144, 145, 153, 257, 258, 260, 261)
CLUSTERS_MORE = (82, 85, 86, 158, 513, 514, 768, 2820)
CLUSTERS_MEASURED = (1024, 1026, 1027, 1028, 1029, 1030, 1036, 1037, 1066, 1068, 1069, 1070, 1072)
ATTRIBUTES = (*range(32), 41, 51, 0x505, 0x600, 0x601, 16384, 16385, 16394, 16395, 16396, 65532)
WANTED: tuple[PlainValue, ...] = (True, False, 0.0, 50.0, 4000.0, 20.0, (120.0, 50.0))
FEATURES = (0, 1, 2, 5, 31, 4096, 0xFFFF)


def test_damaged_nodes_are_refused_or_read(fuzz: Fuzz) -> None:
    for damage, rng in fuzz("matter nodes"):
        attributes = dict(rng.choice(NODES))
        for _ in range(rng.randrange(12)):
            cluster = rng.choice((*CLUSTERS, *CLUSTERS_MORE, *CLUSTERS_MEASURED))
            attribute = rng.choice(ATTRIBUTES)
            known = rng.choice(
                (*FEATURES, None, True, -1, 1e9, [], [{"0": "a", "1": 1, "2": [{"1": 16385}, 7]}], {"0": 5}, "x")
            )
            attributes[f"{rng.choice((0, 1, 2))}/{cluster}/{attribute}"] = known
        data: object = {"node_id": 1, "available": True, "attributes": attributes}
        if rng.random() < 0.5:
            data = damage.damaged(data)
        try:
            node = MatterNode.parse(data)
        except WireError:
            continue
        for device in node.devices():
            check_device(rng, device)
        for endpoint in node.endpoints.values():
            press_of(endpoint, rng.randrange(8), rng.choice((None, 5, {"newPosition": rng.choice((1, "x", None))})))


def check_device(rng: random.Random, device: NodeDevice) -> None:
    for part in device.device.parts:
        endpoint, rows = device.rows[part.id]
        for row, capability in zip(rows, part.capabilities, strict=True):
            assert capability.name in CAPABILITIES
            if row.read is not None:
                value = row.read(endpoint)
                assert can_report(part, capability.name, value), (capability.name, value)
            if capability.settable:
                wanted: PlainValue = rng.choice((*WANTED, *capability.options))
                try:
                    command = checked_command(part, capability.name, wanted, transition=rng.choice((0.0, 1.5, 1e5)))
                    orders = writer_of(rows, row.capability)(endpoint, command)
                except RefusedError:
                    continue
                for order in orders:
                    json.dumps(order.server_call(1, endpoint.id), allow_nan=False)


def test_damaged_frames_are_refused_or_read(fuzz: Fuzz) -> None:
    frames = (
        {"event": "attribute_updated", "data": [1, "1/6/0", True]},
        {"message_id": "1", "result": []},
        {"message_id": "1", "error_code": 3, "details": "x"},
        {"schema_version": 11, "min_supported_schema_version": 9, "sdk_version": "2025"},
    )

    for damage, rng in fuzz("matter frames"):
        frame = damage.damaged_bytes(json.dumps(rng.choice(frames)).encode())
        fields: Mapping[str, object] = {}
        with suppress(WireError):
            fields = as_fields(parse_json(frame, MAX_FRAME_BYTES))
            check_greeting(fields)
        with suppress(LinkError, RefusedError):
            result_of("it", fields)
        with suppress(WireError):
            data = fields.get("data")
            parse_path(data[1] if isinstance(data, list) and len(data) > 1 else data)
