"""The table of a Matter gateway."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from homebot.gateways.matter import MatterGatewaySettings


@pytest.mark.parametrize(
    ("url", "reason"),
    [
        ("127.0.0.1:5580", "written like"),
        ("mqtt://127.0.0.1", "written like"),
        ("ws:///ws", "written like"),
        ("ws://me:secret@host/ws", "no password"),
        ("ws://[::1", "url"),
    ],
)
def test_an_address_that_is_none_is_refused_with_the_reason(url: str, reason: str) -> None:
    with pytest.raises(ValidationError, match=reason):
        MatterGatewaySettings(url=url)
