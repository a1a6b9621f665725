"""What the doctor says of a gateway and of a node."""

from __future__ import annotations

import pytest

from homebot.cli.commands.doctor import print_gateway, print_health
from homebot.devices import GatewayState
from homebot.devices.health import Count, HealthResponse


@pytest.mark.parametrize(
    ("state", "line"),
    [
        (None, "gateway ble does not report its state"),
        (GatewayState(state="active", reason="", acts=True), "gateway ble is active and sends commands"),
        (
            GatewayState(state="active", reason="another acts", acts=False),
            "gateway ble is active and only observes: another acts",
        ),
        (
            GatewayState(state="unavailable", reason="there is no D-Bus", acts=True),
            "gateway ble is unavailable: there is no D-Bus",
        ),
    ],
)
def test_a_gateway_that_is_unavailable_is_not_said_to_send_commands(
    capsys: pytest.CaptureFixture[str], state: GatewayState | None, line: str
) -> None:
    assert print_gateway("ble", state) is line.startswith("gateway ble is active")
    assert capsys.readouterr().out == f"{line}\n"


def test_a_count_that_alone_makes_all_not_well_is_called_a_problem(capsys: pytest.CaptureFixture[str]) -> None:
    """Who reads "problems found" at the end is to see which line is meant."""
    counts = {"announcements_rejected": 2, "commands_failed": 1, "inbox_dropped": 7, "reports_lost": 0}
    health = HealthResponse(counts=tuple(Count(name=name, count=count) for name, count in counts.items()))
    assert not print_health("gateway/mqtt", health, 0.0, everything=False)
    assert [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()] == [
        "counted by gateway/mqtt since it started:",
        "announcements rejected 2",
        "commands failed 1 a problem; homebot journal tells more",
        "inbox dropped 7 a problem",
    ]
