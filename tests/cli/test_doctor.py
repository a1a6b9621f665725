"""The line of the doctor about a gateway."""

from __future__ import annotations

import pytest

from homebot.cli.commands.doctor import print_gateway
from homebot.cli.records import GatewayStateRecord


@pytest.mark.parametrize(
    ("state", "line"),
    [
        (None, "gateway ble does not report its state"),
        (GatewayStateRecord(state="active", reason="", acts=True), "gateway ble is active and sends commands"),
        (
            GatewayStateRecord(state="active", reason="another acts", acts=False),
            "gateway ble is active and only observes: another acts",
        ),
        (
            GatewayStateRecord(state="unavailable", reason="there is no D-Bus", acts=True),
            "gateway ble is unavailable: there is no D-Bus",
        ),
    ],
)
def test_a_gateway_that_is_unavailable_is_not_said_to_send_commands(
    capsys: pytest.CaptureFixture[str], state: GatewayStateRecord | None, line: str
) -> None:
    assert print_gateway("ble", state) is line.startswith("gateway ble is active")
    assert capsys.readouterr().out == f"{line}\n"
