"""``homebot do``: the request that it makes of its arguments, and what it prints of the answer."""

from typing import Any

import pytest

from homebot.cli import main
from homebot.devices import KeyValue
from homebot.devices.command_messages import (
    CommandDevices,
    CommandDevicesRequest,
    CommandDevicesResponse,
    CommandedPart,
    CommandResult,
)
from homebot.devices.names import COMMAND_DEVICES
from homebot.devices.outcomes import Confirmed, Evidence, Outcome, Refused, worst
from homebot.graph import Node

Text = pytest.CaptureFixture[str]

CONFIRMED = Confirmed(0.12, Evidence.REPORTED, command_id="c-1")


def answer(*outcomes: Outcome, message: str = "") -> CommandDevicesResponse:
    """What the command service answers where these outcomes are those of lamps."""
    results = tuple(
        CommandedPart(device=f"lamp{number}", name=f"Lamp {number}", part="", result=CommandResult.of(one))
        for number, one in enumerate(outcomes)
    )
    is_done = bool(outcomes) and all(one.succeeded for one in outcomes)
    outcome = CommandResult.of(worst(outcomes)).outcome if outcomes else ""
    return CommandDevicesResponse(success=is_done, message=message, outcome=outcome, results=results)


class Service:
    """Answers what a test says, and keeps what it was asked."""

    def __init__(self, homebot: Any, response: CommandDevicesResponse) -> None:
        self.requests: list[CommandDevicesRequest] = []
        self._door = homebot.door
        self._response = response
        homebot.do(lambda: Node(homebot.graph, "control").create_service(CommandDevices, COMMAND_DEVICES, self._serve))

    def run(self, *arguments: str) -> int:
        return main(["--door", self._door, "do", *arguments])

    def _serve(self, request: CommandDevicesRequest) -> CommandDevicesResponse:
        self.requests.append(request)
        return self._response


def test_a_long_refusal_is_shown_to_its_end_where_the_advice_is(homebot: Any, capsys: Text) -> None:
    refused = Refused("rights", f"{'word ' * 60}; give it a token")
    assert Service(homebot, answer(refused)).run("Lamp 0", "on") == 1
    assert capsys.readouterr().out.endswith("; give it a token\n")


@pytest.mark.parametrize("change", ["-10%", "-10 %", "-10", "-.1", "-1K"])
def test_a_change_downwards_is_no_option(homebot: Any, change: str) -> None:
    service = Service(homebot, answer(CONFIRMED))
    assert service.run("Lamp 0", change) == 0
    assert [request.command for request in service.requests] == [change]


def test_why_nothing_was_commanded_is_told(homebot: Any, capsys: Text) -> None:
    assert Service(homebot, answer(message="no device fits 'lmap'")).run("lmap", "on") == 1
    assert capsys.readouterr().err == "homebot: no device fits 'lmap'\n"


@pytest.mark.parametrize(
    ("arguments", "command", "values"),
    [
        (["on"], "on", {}),
        (["on", "--level", "40", "--kelvin", "2700"], "on", {"level": "40", "color_temperature": "2700"}),
        (["level", "40"], "set", {"level": "40"}),
        (["color", "--color", "120,80"], "set", {"color": "120,80"}),
        (["lock"], "lock", {}),
        (["level"], "level", {}),
        (["heating_setpoint", "21", "°C"], "set", {"heating_setpoint": "21 °C"}),
        (["2700", "K"], "2700 K", {}),
        (["arm", "home"], "arm home", {}),
    ],
)
def test_the_request_is_what_the_arguments_say(
    homebot: Any, arguments: list[str], command: str, values: dict[str, str]
) -> None:
    service = Service(homebot, answer(CONFIRMED))
    service.run("Lamp 0", *arguments, "--transition", "3000ms")
    (request,) = service.requests
    assert (request.target, request.command, request.transition) == ("Lamp 0", command, 3.0)
    assert request.values == tuple(KeyValue(key=name, value=value) for name, value in values.items())


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ((), "error: the following arguments are required: COMMAND\n"),
        (("on", "--transition", "nan"), "'nan' is not a duration; write it like 90s"),
    ],
)
def test_a_wrong_command_line_says_what_is_wrong(
    homebot: Any, capsys: Text, arguments: tuple[str, ...], problem: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        Service(homebot, answer(CONFIRMED)).run("Lamp 0", *arguments)
    assert ended.value.code == 2
    assert problem in capsys.readouterr().err
