"""A code goes to the device that wants it, and nowhere else."""

import json
import logging
from typing import Any

import pytest
from structlog.testing import capture_logs
from tests.gateways.mqtt.simple_house import simple_house

from homebot.conventions.description import Publication
from homebot.devices import RawMessage, SubscribeToTopic
from homebot.devices.gateway_messages import Command, SendCommand, SendCommandResponse
from homebot.devices.value import Value
from homebot.errors import TypeMismatchError
from homebot.gateways.mqtt.command_publisher import MAX_SECRETS, SentSecrets
from homebot.messages.json import message_from_json

pytestmark = pytest.mark.virtual_time

CONVENTION = "homebot.conventions.homeassistant:HomeAssistantDiscovery"
CODE = "73550173"
ALARM = {
    "unique_id": "a",
    "state_topic": "alarm/state",
    "command_topic": "alarm/set",
    "retain": True,
    "code": "REMOTE_CODE",
    "command_template": '{"action": "{{ action }}", "code": "{{ code }}"}',
}
SPY = {"unique_id": "s", "state_topic": "alarm/set"}
"""A sensor that listens where the alarm is told."""


async def send(house: Any, value: str, code: str, *, key: str = "alarm_control_panel/x", part: str = "a") -> Any:
    command = Command(key=f"homeassistant:{key}", part=part, capability="alarm", value=Value.of(value), code=code)
    response: SendCommandResponse = await house.watcher.create_client(
        SendCommand, house.gateway.names.send_command
    ).call(command)
    return response


async def test_a_code_is_sent_to_the_alarm_and_neither_kept_nor_mirrored_nor_logged(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Not even to who listens to the very topic, and reads it as a state."""
    caplog.set_level(logging.DEBUG)
    with capture_logs() as lines:
        async with simple_house(conventions=(CONVENTION,)) as house:
            await house.listen("alarm/set")
            await house.say("homeassistant/alarm_control_panel/x/config", json.dumps(ALARM))
            await house.say("homeassistant/sensor/s/config", json.dumps(SPY))
            mirror = house.watcher.create_subscription(RawMessage, "~/inbox", qos_profile=10)
            ask = house.watcher.create_client(SubscribeToTopic, house.gateway.names.subscribe)
            assert (await ask.call(SubscribeToTopic.Request(topic="alarm/set", listener="/watcher"))).success
            response = await send(house, "disarmed", CODE)
            assert response.success
            assert [(one.payload, one.retain) for one in await house.heard()] == [
                (b'{"action": "DISARM", "code": "73550173"}', False)
            ]
            assert mirror.take() is None
            assert CODE not in str(house.told())
            await house.say("alarm/set", "what others say there is heard")
            assert mirror.take() is not None
    assert CODE not in f"{lines} {caplog.text}"


@pytest.mark.parametrize(
    ("value", "code", "why"),
    [("disarmed", "", "it needs a code"), ("pending", CODE, "it takes disarmed"), ("disarmed", CODE, None)],
)
async def test_a_refusal_shows_no_code(value: str, code: str, why: str | None) -> None:
    async with simple_house(conventions=(CONVENTION,), act=why is not None) as house:
        await house.say("homeassistant/alarm_control_panel/x/config", json.dumps(ALARM))
        response = await send(house, value, code)
        assert not response.success
        assert (why or "only observes") in response.message
        assert CODE not in response.message


async def test_no_other_way_to_an_alarm_is_tried_with_a_wrong_code() -> None:
    """It might ask for none."""
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.say("homeassistant/alarm_control_panel/x/config", json.dumps({**ALARM, "code": "1"}))
        response = await send(house, "disarmed", CODE)
        assert (response.problem, response.unable) == ("refused", False)


async def test_a_part_without_a_code_is_not_commanded_with_one() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        command = Command(key="simple:lamp1", part="lamp", capability="on_off", value=Value.of(plain=True), code=CODE)
        client = house.watcher.create_client(SendCommand, house.gateway.names.send_command)
        response = await client.call(command)
        assert not response.success
        assert "it takes no code" in response.message


def test_a_command_shows_no_code_where_it_is_shown() -> None:
    command = Command(key="k", part="p", capability="alarm", value=Value.of("disarmed"), code=CODE)
    assert CODE not in f"{command!r} {command}"


@pytest.mark.parametrize("code", [73550173, [CODE], {"code": CODE}, CODE * 100])
def test_a_code_that_cannot_be_one_is_not_shown_in_the_error(code: object) -> None:
    fields = {"key": "k", "part": "p", "capability": "alarm", "value": {"type": 3, "text": "disarmed"}, "code": code}
    with pytest.raises(TypeMismatchError) as refused:
        message_from_json(Command, fields)
    assert CODE not in f"{refused.value} {refused.value.__cause__} {refused.value.__context__}"


def test_the_secrets_that_are_known_are_bounded_and_hold_no_code() -> None:
    secrets = SentSecrets()
    for number in range(MAX_SECRETS + 1):
        secrets.record(Publication(f"t/{number}", CODE.encode()))
    assert not secrets.is_one("t/0", CODE.encode())
    assert secrets.is_one(f"t/{MAX_SECRETS}", CODE.encode())
    assert not secrets.is_one(f"t/{MAX_SECRETS}", b"other")
    assert CODE not in str(vars(secrets))
