"""The mDNS gateway names the next step with what only another gateway can use."""

import pytest

from homebot.conventions.dns_sd import FoundService
from homebot.gateways.mdns.gateway_hints import hint_facts
from homebot.gateways.mdns.settings import KNOWN_TYPES

HOME_ASSISTANT, HUE, HAP = "_home-assistant._tcp.local.", "_hue._tcp.local.", "_hap._tcp.local."
INTERNAL = {"internal_url": "http://192.168.1.20:8123", "base_url": "http://elsewhere"}


def found(service_type: str, **properties: str) -> FoundService:
    return FoundService(f"Hall.{service_type}", "Hall", service_type, "ha.local.", 8123, ("192.168.1.20",), properties)


@pytest.mark.parametrize(
    ("service", "gateway", "step"),
    [
        (found(HOME_ASSISTANT, **INTERNAL), "homeassistant", 'url = "http://192.168.1.20:8123" and token_file'),
        (
            found(HOME_ASSISTANT),
            "homeassistant",
            'if it is yours, add [gateways.homeassistant] with url = "http://ha.local:8123"',
        ),
        (found(HUE), "hue", "add [gateways.hue], then: homebot pair 'Hall'"),
        (found(HAP, sf="1"), "homekit", "add [gateways.homekit], then: homebot pair 'Hall' CODE"),
        (found("_hap._udp.local.", sf="1"), "homekit", "add [gateways.homekit], then: homebot pair 'Hall' CODE"),
        (found(HAP, sf="5"), "homekit", "add [gateways.homekit]"),
    ],
)
def test_a_service_whose_gateway_is_not_configured_has_the_next_step(
    service: FoundService, gateway: str, step: str
) -> None:
    facts = hint_facts(service, {"mdns"})
    assert facts["needs_gateway"] == gateway
    assert step in facts["next_step"]
    assert service.service_type in KNOWN_TYPES
    assert hint_facts(service, {"mdns", gateway}) == {}, "it is configured"
    assert hint_facts(service, None) == {}, "nothing is known of other gateways"


@pytest.mark.parametrize(
    "service",
    [found("_shelly._tcp.local."), *(found(HAP, sf=flags) for flags in ("0", "4", "", "x", "\N{SUPERSCRIPT TWO}"))],
    ids=str,
)
def test_a_service_that_homebot_uses_itself_or_that_is_paired_elsewhere_has_none(service: FoundService) -> None:
    assert hint_facts(service, set()) == {}


def test_a_step_shows_all_its_characters() -> None:
    assert hint_facts(found(HOME_ASSISTANT, internal_url="\x1b[31m"), set())["next_step"].isprintable()
