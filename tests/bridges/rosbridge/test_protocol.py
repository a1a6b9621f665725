"""Frames of rosbridge v2, in and out."""

import json

import pytest
from tests.bridges.frames import parse_frame

from homebot.bridges.rosbridge import protocol
from homebot.bridges.rosbridge.protocol import (
    CallService,
    FrameError,
    PublishOperation,
    ServiceResponse,
    SubscribeOperation,
    failure_frame,
    frame_text,
    publish_frame,
)
from homebot.messages import String


def test_a_frame_of_roslibpy_is_read() -> None:
    """Golden text: what roslibpy 2.1 sends for a subscription."""
    op = parse_frame(
        '{"op": "subscribe", "id": "subscribe:/chatter:1", "type": "std_msgs/String", "topic": "/chatter", '
        '"compression": "none", "throttle_rate": 0, "queue_length": 0}'
    )
    assert op == SubscribeOperation(op="subscribe", id="subscribe:/chatter:1", topic="/chatter", type="std_msgs/String")


def test_null_counts_as_left_out() -> None:
    op = parse_frame('{"op": "call_service", "service": "/s", "args": null, "timeout": null, "id": null}')
    assert op == CallService(op="call_service", service="/s")


def test_a_response_without_a_result_is_a_no() -> None:
    """Roslibpy sends null when a callback returned nothing."""
    op = parse_frame('{"op": "service_response", "id": "1", "service": "/s", "values": {}, "result": null}')
    assert isinstance(op, ServiceResponse)
    assert not op.result


def test_a_number_may_be_an_identifier() -> None:
    assert parse_frame('{"op": "publish", "id": 7, "topic": "/t", "msg": {}}') == PublishOperation(
        op="publish", id=7, topic="/t", msg={}
    )


def test_a_whole_number_may_be_written_with_a_point() -> None:
    """As Godot writes numbers that it read from JSON; without its id, the answer of a call would find nobody."""
    call = parse_frame('{"op": "call_service", "id": 7.0, "service": "/s"}')
    assert (call.id, type(call.id)) == (7, int)
    subscription = parse_frame('{"op": "subscribe", "topic": "/t", "queue_length": 1.0}')
    assert subscription == SubscribeOperation(op="subscribe", topic="/t", queue_length=1)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "the frame is not JSON: Expecting value"),
        ("{", "the frame is not JSON"),
        ('{"op": "publish", "op": "advertise"}', "the frame is ambiguous: the key 'op' occurs twice"),
        ('{"op": "publish", "topic": "/a", "msg": {"data": 1, "data": 2}}', "the frame is ambiguous: the key 'data'"),
        ("[]", r"the frame is not a JSON object: '\[\]'"),
        ("{}", "the frame lacks the field 'op'"),
        ('{"op": 3}', "the frame needs a string in its field 'op', got '3'"),
        ('{"op": "fly"}', "uses the unknown operation 'fly'; known are action_feedback, .*unsubscribe"),
        ('{"op": "publish", "topic": "/t"}', "publish: field 'msg' is missing"),
        ('{"op": "publish", "topic": "/t", "msg": 5}', "publish: field 'msg': .*dict.*, got 5"),
        ('{"op": "publish", "topic": "", "msg": {}}', "publish: field 'topic': .*at least 1 character, got ''"),
        ('{"op": "subscribe", "topic": "/t", "throttle_rate": -1}', "'throttle_rate': .*greater than or equal to 0"),
        ('{"op": "subscribe", "topic": "/t", "throttle_rate": NaN}', "'throttle_rate'"),
        ('{"op": "subscribe", "topic": "/t", "queue_length": "10"}', "'queue_length': .*integer, got '10'"),
        ('{"op": "set_level", "level": "loud"}', "'level': .*'none', 'error'.*got 'loud'"),
        ('{"op": "call_service", "service": "/s", "timeout": "soon"}', "'timeout': .*number, got 'soon'"),
        ('{"op": "publish", "topic": "/t", "msg": {"data": "\\ud800"}}', "half of a surrogate pair"),
        ('{"op": "publish", "topic": "/t", "msg": ' + '{"a":' * 200 + "1" + "}" * 201, "nested more than 100 deep"),
        ("[" * 10_000, "nested more than 100 deep"),
        ("[" * 100_000, "holds more than 20,000 values"),
        ('{"op": "publish", "msg": {"data": [' + "0," * 20_000 + '""]}}', "holds more than 20,000 values"),
        ('{"op": "publish", "msg": {"data": [' + "[0,0]," * 20_000 + "0]}}", "holds more than 20,000 values"),
        ('{"op": "publish", "msg": {"data": [' + "0," * 1_000_000 + "0]}}", "holds more than 1,000,000 numbers"),
        ('{"data": [' + "0," * 70_000 + "]}", "is not JSON"),
        ('{"data": [' + "0," * 70_000 + " ]}", "is not JSON"),
        ('{"data": [' + "0," * 70_000 + ",0]}", "is not JSON"),
        ('{"data": [' + "0" * 70_000 + "]}", "is not JSON"),
        ('{"a": -Infinity, "data": [' + "0," * 70_000 + "0]}", "holds more than 20,000 values"),
        ('{"op": "subscribe", "topic": "/' + "t" * 600 + '"}', "field 'topic': .*at most 500 characters"),
        ('{"op": "subscribe", "topic": "/t", "id": "' + "i" * 1001 + '"}', "field 'id': .* up to 1000 characters"),
        ('{"op": "publish", "id": ' + "9" * 5000 + "}", "not JSON"),
    ],
)
def test_a_bad_frame_is_refused_with_the_field_and_its_value(text: str, problem: str) -> None:
    with pytest.raises(FrameError, match=problem):
        parse_frame(text)


def test_a_large_frame_is_read_in_steps_as_json_reads_it() -> None:
    """A raw image that is no base64, a map, and what looks like numbers inside texts."""
    image = [number % 256 for number in range(640 * 480 * 3)]
    cells = [-1, 0, 100] * 8000
    text = json.dumps(
        {
            "op": "publish",
            "topic": "/t",
            "msg": {
                "image": {"data": image},
                "map": [cells, [1.5e3, -0.25] * 5000],
                "text": str(cells) + '"\\',
                "numbers": {"numbers": [0]},
                "empty": [],
            },
        }
    )
    assert sum(1 for _ in protocol.parse_frame(text)) > 50
    op = parse_frame(text)
    assert isinstance(op, PublishOperation)
    assert op.msg == json.loads(text)["msg"]


def test_a_bad_call_can_still_be_answered() -> None:
    """The error keeps what the answer needs."""
    with pytest.raises(FrameError) as caught:
        parse_frame('{"op": "call_service", "id": "x:1", "service": "/s", "args": 4}')
    assert (caught.value.op, caught.value.id, caught.value.name) == ("call_service", "x:1", "/s")


def test_frames_out_have_the_fields_that_clients_read() -> None:
    """Golden texts."""
    assert publish_frame("/t", String(data="é")) == '{"op":"publish","topic":"/t","msg":{"data":"\\u00e9"}}'
    values = '{"success":true,"message":""}'
    assert frame_text("service_response", "1", {"service": "/s", "result": True}, values=values) == (
        '{"op":"service_response","service":"/s","result":true,"id":"1","values":{"success":true,"message":""}}'
    )
    call = parse_frame('{"op": "call_service", "service": "/s"}')
    assert failure_frame(call, "no") == '{"op":"service_response","service":"/s","values":"no","result":false}'
    goal = parse_frame('{"op": "send_action_goal", "action": "/a", "id": "g"}')
    assert failure_frame(goal, "no") == (
        '{"op":"action_result","action":"/a","status":0,"values":"no","result":false,"id":"g"}'
    )
    assert publish_frame('/"', String(data=""), lost=2) == '{"op":"publish","topic":"/\\"","msg":{"data":""},"lost":2}'
