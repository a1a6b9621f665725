"""Any frames at the door: an operation, or a FrameError."""

import json
from contextlib import suppress

from tests.bridges.frames import parse_frame
from tests.fuzz.conftest import Fuzz

from homebot.bridges.rosbridge.protocol import FrameError, Operation
from homebot.devices import RawMessage
from homebot.devices.gateway_messages import Command
from homebot.errors import TypeMismatchError
from homebot.messages import Message
from homebot.messages.json import message_from_json

FRAMES = (
    {"op": "advertise", "topic": "/t", "type": "std_msgs/String", "id": "1", "latch": True, "queue_size": 10},
    {"op": "publish", "topic": "/t", "msg": {"data": "x"}, "latch": False},
    {"op": "subscribe", "topic": "/t", "type": "std_msgs/String", "throttle_rate": 5, "queue_length": 1},
    {"op": "call_service", "service": "/s", "args": {"topic": "a", "listener": "/b"}, "timeout": 1.5},
    {"op": "advertise_service", "service": "/s", "type": "std_srvs/SetBool"},
    {"op": "service_response", "service": "/s", "id": 7, "values": {}, "result": True},
    {"op": "set_level", "level": "error"},
    {"op": "auth", "mac": "x", "client": "c", "dest": "d", "rand": "r", "t": 1, "level": "l", "end": 2},
    {"op": "send_action_goal", "action": "/a", "args": {"order": 3}},
)
WORDS = tuple(sorted({word for one in FRAMES for word in (*one, str(one["op"]))}))
MESSAGES: tuple[type[Message], ...] = (RawMessage, Command)


def test_any_frame_is_an_operation_or_refused(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("door frames", WORDS):
        text = mutate.damaged_json(json.dumps(rng.choice(FRAMES))).decode(errors="surrogateescape")
        with suppress(FrameError):
            assert isinstance(parse_frame(text), Operation)
        message_type = rng.choice(MESSAGES)
        fields = {name: mutate.value() for name in message_type.model_fields if rng.random() < 0.95}
        with suppress(TypeMismatchError):
            assert isinstance(message_from_json(message_type, fields), message_type)
