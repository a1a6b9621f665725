"""What is known of HomeKit's services on the network."""

import pytest

from homebot.conventions.dns_sd import FoundService
from homebot.integrations.homekit.formats.ecosystem import Homekit


@pytest.mark.parametrize(("model", "is_own"), [("homebot", True), ("BSB002", False)])
def test_a_bridge_of_homebot_is_its_own(model: str, is_own: bool) -> None:  # noqa: FBT001 - a parameter of pytest
    kind = "_hap._tcp.local."
    service = FoundService(f"B.{kind}", "B", kind, "b.local.", 51826, ("192.168.1.2",), {"md": model, "sf": "1"})
    assert Homekit.is_own(service) is is_own
