"""What integrations know of services on the network: identifiers, and the next step with what their gateways use."""

import pytest

from homebot.conventions.dns_sd import FoundService, identifiers_of, name_of
from homebot.conventions.ecosystem import Ecosystem, ecosystems, hint_facts
from homebot.integrations.homekit.formats.ecosystem import Homekit
from homebot.integrations.matter.formats.ecosystem import Matter

HOME_ASSISTANT, HUE, HAP = "_home-assistant._tcp.local.", "_hue._tcp.local.", "_hap._tcp.local."
NODE = "2906C908D115D362-8FC7772401CD0696"
INTERNAL = {"internal_url": "http://192.168.1.20:8123", "base_url": "http://elsewhere"}


def found(service_type: str, **properties: str) -> FoundService:
    return FoundService(f"Hall.{service_type}", "Hall", service_type, "ha.local.", 8123, ("192.168.1.20",), properties)


def known_by(service: FoundService) -> type[Ecosystem]:
    return next((one for one in ecosystems() if service.service_type in one.service_types), Ecosystem)


def hint(service: FoundService, configured: set[str] | None) -> dict[str, str]:
    return hint_facts(known_by(service), service, configured)


def test_of_matter_the_host_is_the_hardware_address_and_the_instance_is_the_node() -> None:
    for host in ("B827EBA1B2C3.local.", "B827EBA1B2C30000.local."):  # the second is on matter.js
        node = FoundService("", NODE, "_matter._tcp.local.", host, 5540, (), {"sii": "5000"})
        assert identifiers_of(node, Matter.declared(node)) == (
            "mac:b827eba1b2c3",
            f"id:matter:deviceid_{NODE}-MatterNodeDevice",
        )


def test_a_node_of_matter_that_can_be_commissioned_says_its_name() -> None:
    assert name_of(found("_matterc._udp.local.", dn="Plug"), Matter.name_key) == "Plug"


def test_the_pairing_id_of_homekit_is_no_hardware_address() -> None:
    lamp = found(HAP, id="A8:03:2A:BE:54:DC", md="Lamp 1", sf="0")
    assert identifiers_of(lamp, Homekit.declared(lamp)) == ("id:homekit A8:03:2A:BE:54:DC pairing",)


@pytest.mark.parametrize(
    ("service", "gateway", "step"),
    [
        pytest.param(
            found(HOME_ASSISTANT, **INTERNAL),
            "homeassistant",
            'url = "http://192.168.1.20:8123" and token_file',
            marks=pytest.mark.rooms("homeassistant"),
        ),
        pytest.param(
            found(HOME_ASSISTANT),
            "homeassistant",
            'if it is yours, add [gateways.homeassistant] with url = "http://ha.local:8123"',
            marks=pytest.mark.rooms("homeassistant"),
        ),
        pytest.param(
            found(HUE), "hue", "add [gateways.hue], then: homebot pair 'Hall'", marks=pytest.mark.rooms("hue")
        ),
        (found(HAP, sf="1"), "homekit", "add [gateways.homekit], then: homebot pair 'Hall' CODE"),
        (found("_hap._udp.local.", sf="1"), "homekit", "add [gateways.homekit], then: homebot pair 'Hall' CODE"),
        (found(HAP, sf="5"), "homekit", "add [gateways.homekit]"),
    ],
)
def test_a_service_whose_gateway_is_not_configured_has_the_next_step(
    service: FoundService, gateway: str, step: str
) -> None:
    facts = hint(service, {"mdns"})
    assert facts["needs_gateway"] == gateway
    assert step in facts["next_step"]
    assert hint(service, {"mdns", gateway}) == {}, "it is configured"
    assert hint(service, None) == {}, "nothing is known of other gateways"


@pytest.mark.parametrize(
    "service",
    [found("_shelly._tcp.local."), *(found(HAP, sf=flags) for flags in ("0", "4", "", "x", "\N{SUPERSCRIPT TWO}"))],
    ids=str,
)
def test_a_service_that_homebot_uses_itself_or_that_is_paired_elsewhere_has_none(service: FoundService) -> None:
    assert hint(service, set()) == {}


@pytest.mark.rooms("homeassistant")
def test_a_step_shows_all_its_characters() -> None:
    assert hint(found(HOME_ASSISTANT, internal_url="\x1b[31m"), set())["next_step"].isprintable()
