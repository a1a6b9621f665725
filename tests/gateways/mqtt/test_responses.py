"""Responses of devices to commands: what they mean, and how many are awaited."""

import pytest

from homebot.clock import ManualClock
from homebot.devices.gateway_messages import Command, CommandAnswer
from homebot.devices.value import Value
from homebot.gateways.mqtt.command_publisher import MAX_AWAITED, Responses, problem_of
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.packets import NO_PROPERTIES, Properties


@pytest.mark.parametrize(
    ("response", "problem"),
    [
        (b"", ""),
        (b"OK", ""),
        (b"[1]", ""),
        (b'{"status": "ok"}', ""),
        (b'{"error": null, "result": {}}', ""),
        (b'{"status": "error", "error": "no such lamp"}', "no such lamp"),
        (b'{"error": {"code": -103, "message": "overheated"}}', "overheated"),
        (b'{"success": false, "message": "locked"}', "locked"),
        (b'{"error": true}', "the device refuses"),
        (b'{"error": "a\\u0007b\\n c"}', "a b c"),
        (b'{"error": "' + b"x" * 300 + b'"}', "x" * 200),
        (b'{"error": "' + b"x" * 9999 + b'"}', ""),
    ],
)
def test_a_response_with_an_error_refuses_and_any_other_accepts(response: bytes, problem: str) -> None:
    assert problem_of(response) == problem


class Asked:
    """Responses, with what was published of them."""

    def __init__(self) -> None:
        self.answers: list[CommandAnswer] = []
        self.clock = ManualClock()
        self.responses = Responses("mqtt", "homebot/responses/test", self.clock, self.answers.append)

    def ask(self, command_id: str) -> Properties:
        command = Command(
            key="k", part="p", capability="on_off", value=Value.of(True), expires_after=9.5, id=command_id
        )
        return self.responses.request(command, Properties(message_expiry_interval=10))

    def answer(self, properties: Properties, *, retain: bool = False) -> None:
        same = Properties(correlation_data=properties.correlation_data)
        self.responses.on_response(MqttMessage("homebot/responses/test", b"", 1, retain, same))


def test_a_response_is_matched_with_its_command_once() -> None:
    asked = Asked()
    first, second = asked.ask("1"), asked.ask("2")
    assert (first.response_topic, first.message_expiry_interval) == ("homebot/responses/test", 10)
    assert first.user_properties == (("command", "1"),)  # its id in the journal
    assert first.correlation_data is not None
    assert first.correlation_data.isalnum()  # which a shell script can repeat
    asked.answer(second)
    asked.answer(second)
    assert [(one.command_id, one.gateway, one.key, one.success) for one in asked.answers] == [("2", "mqtt", "k", True)]
    assert (asked.responses.counters.responses, asked.responses.counters.responses_unknown) == (1, 1)


def test_only_so_many_are_awaited_and_the_oldest_is_forgotten() -> None:
    asked = Asked()
    properties = [asked.ask(str(number)) for number in range(MAX_AWAITED + 1)]
    asked.answer(properties[0])
    asked.answer(properties[1])
    assert [one.command_id for one in asked.answers] == ["1"]
    assert asked.responses.counters.responses_unknown == 1


def test_late_retained_or_uncorrelated_responses_are_only_counted() -> None:
    asked = Asked()
    late, kept = asked.ask("1"), asked.ask("2")
    asked.answer(kept, retain=True)
    asked.answer(NO_PROPERTIES)
    asked.clock.advance(10)
    asked.answer(late)
    assert asked.answers == []
    assert (asked.responses.counters.responses_late, asked.responses.counters.responses_unknown) == (1, 2)


def test_a_command_without_a_waiting_caller_asks_for_no_response() -> None:
    asked = Asked()
    assert asked.ask("").response_topic is None
