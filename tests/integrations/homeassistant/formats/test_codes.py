"""A code goes to the device that wants it, and nowhere else."""

import json
import logging
from typing import Any

import anyio
import pytest
from structlog.testing import capture_logs
from tests.gateways.mqtt.simple_house import simple_house

from homebot.devices.gateway_messages import Command, SendCommand, SendCommandResponse
from homebot.devices.value import Value
from homebot.errors import TypeMismatchError
from homebot.messages.json import message_from_json

pytestmark = pytest.mark.virtual_time

CONVENTION = "homebot.integrations.homeassistant.formats:HomeAssistantDiscovery"
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

SPY_KEY = "homeassistant:sensor/s"


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
            assert "no device publishes" in (await house.subscribe("alarm/set")).message
            response = await send(house, "disarmed", CODE)
            assert response.success
            assert [(one.payload, one.retain) for one in await house.heard()] == [
                (b'{"action": "DISARM", "code": "73550173"}', False)
            ]
            assert house.told() == []
    assert CODE not in f"{lines} {caplog.text}"


@pytest.mark.parametrize("state_topic", ["alarm/set", "alarm/+", "homeassistant/alarm_control_panel/x/config"])
@pytest.mark.parametrize("is_first", [False, True])
async def test_nobody_reads_what_other_clients_tell_an_alarm_or_its_announcement(
    state_topic: str,
    is_first: bool,  # noqa: FBT001 - the case
) -> None:
    spy = ("homeassistant/sensor/s/config", json.dumps({**SPY, "state_topic": state_topic}))
    alarm = ("homeassistant/alarm_control_panel/x/config", json.dumps({**ALARM, "code": CODE}))
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.say(*(spy if is_first else alarm), retain=True)
        mirror = await house.subscribe(state_topic.replace("+", "set"))
        await house.say(*(alarm if is_first else spy), retain=True)
        await house.say("alarm/set", json.dumps({"action": "DISARM", "code": CODE}))
        await house.say(*alarm, retain=True)
        assert house.told() == []
        assert not mirror.success or house.raw(mirror).take() is None
        await house.say("homeassistant/alarm_control_panel/x/config", "", retain=True)
        await anyio.sleep(20)
        await house.say("alarm/set", "harmless")
        assert [key for key, _, _ in house.told()] == [SPY_KEY] * ("config" not in state_topic)


@pytest.mark.parametrize(
    ("config", "told"),
    [
        ({}, True),
        ({"code_format": "^\\d{4}$", "command_template": '{"do": "{{ value }}", "code": "{{ code }}"}'}, False),
    ],
    ids=["plain", "with a code"],
)
async def test_a_lock_that_reports_where_it_is_told_is_read_unless_a_code_is_told_there(
    config: dict[str, str],
    told: bool,  # noqa: FBT001 - the case
) -> None:
    lock = {"unique_id": "l", "state_topic": "lock", "command_topic": "lock", "state_locked": "LOCK", **config}
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.say("homeassistant/lock/l/config", json.dumps(lock))
        await house.say("lock", "LOCK")
        assert house.told() == ([("homeassistant:lock/l", {"l.lock": "locked"}, False)] if told else [])


@pytest.mark.parametrize(
    ("value", "code", "why"),
    [
        ("disarmed", "", "it needs a code: `homebot do`"),
        ("pending", CODE, "it takes disarmed"),
        ("disarmed", CODE, None),
    ],
)
async def test_a_refusal_shows_no_code(value: str, code: str, why: str | None) -> None:
    async with simple_house(conventions=(CONVENTION,), act=why is not None) as house:
        await house.say("homeassistant/alarm_control_panel/x/config", json.dumps(ALARM))
        response = await send(house, value, code)
        assert not response.success
        assert (why or "only observes") in response.message
        assert CODE not in response.message


@pytest.mark.parametrize(
    ("kind", "config", "code"),
    [
        ("alarm_control_panel", {}, "digits"),
        ("alarm_control_panel", {"code": "REMOTE_CODE_TEXT"}, "text"),
        ("alarm_control_panel", {"code": "hunter2"}, "text"),
        ("alarm_control_panel", {"code": "1234"}, "digits"),
        ("alarm_control_panel", {"code": None}, ""),
        ("lock", {"code_format": "^\\d{4}$"}, "digits"),
        ("lock", {"code_format": "^[a-z]+$"}, "text"),
        ("lock", {}, ""),
    ],
)
async def test_a_keypad_knows_what_a_code_consists_of(kind: str, config: dict[str, str | None], code: str) -> None:
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.say(f"homeassistant/{kind}/x/config", json.dumps({**ALARM, **config}))
        sighting = house.sightings.take()
        assert sighting is not None
        (part,) = sighting.parts
        assert [capability.code for capability in part.capabilities] == [code]


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
