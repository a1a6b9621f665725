"""Endpoints: from configurations, answers and registrations."""

from contextlib import nullcontext

import pytest
from pydantic import ValidationError

from homebot.conventions.coap.endpoint import (
    authority_of,
    endpoint_at,
    endpoint_of_link,
    static_endpoint,
)
from homebot.conventions.coap.link_format import parse_links
from homebot.errors import UsageError, WireError
from homebot.gateways.coap import CoapGateway, CoapGatewaySettings
from homebot.gateways.coap.gateway import SESSION, SESSIONS
from homebot.plugins import has_plugin


def test_an_address_that_answered_is_an_endpoint() -> None:
    assert endpoint_at("192.168.1.5", 5683).base == "coap://192.168.1.5"
    assert endpoint_at("fe80::1%eth0", 5700).base == "coap://[fe80::1%25eth0]:5700"


def test_a_registration_is_an_endpoint_with_its_facts() -> None:
    (link,) = parse_links(
        b'</reg/1/>;ep="urn:dev:mac:a8032abe54dc";d="home";base="coap://[2001:db8::1]:61616/";et="lamp";lt="600"'
    )
    found = endpoint_of_link(link)
    assert (found.key, found.base) == ("urn:dev:mac:a8032abe54dc@home", "coap://[2001:db8::1]:61616")
    assert (found.lifetime, dict(found.facts)) == (600.0, {"sector": "home", "endpoint_type": "lamp"})
    assert found.identifiers == ("mac:a8032abe54dc", "id:urn:dev:mac:a8032abe54dc")
    (plain,) = parse_links(b"</1>;ep=node1;con=coap://h")
    assert endpoint_of_link(plain).identifiers == ()  # another house has a node1 as well


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("</1>;base=coap://h", "has no ep"),
        ("</1>;ep=a", "has no usable base: ''"),
        ("</1>;ep=a;base=http://h", "has no usable base"),
        ("</1>;ep=a;base=coap://", "has no usable base"),
        ('</1>;ep=a;base="coap://[x"', "has no usable base"),
        ("</1>;ep=a;base=coap://h:0", "has no usable base"),
    ],
)
def test_a_registration_without_name_or_address_is_refused(text: str, problem: str) -> None:
    (link,) = parse_links(text.encode())
    with pytest.raises(WireError, match=problem):
        endpoint_of_link(link)


def test_the_default_port_is_no_difference() -> None:
    assert authority_of("coap://H:5683/x") == authority_of("coap://h")
    assert static_endpoint("coap://h/td/lamp").description == "coap://h/td/lamp"
    assert static_endpoint("coap://h/").description == ""


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"devices": ["http://h"]}, "is not an address such as coap://"),
        ({"devices": ["coap://[x"]}, "is not an address"),
        ({"groups": ["ipx"]}, "ipv4"),
        ({"credentials": [{"uri": "coap://*", "identity": "x"}]}, "give either oscore"),
        ({"credentials": [{"uri": "coap://*"}]}, "give either oscore"),
    ],
)
def test_settings_that_cannot_work_are_refused_with_their_key(table: dict[str, object], problem: str) -> None:
    with pytest.raises(ValidationError, match=problem):
        CoapGatewaySettings.model_validate(table)


def test_a_gateway_that_cannot_find_devices_is_an_error() -> None:
    with pytest.raises(UsageError, match="the gateway finds no device: set devices"):
        CoapGateway.check(CoapGatewaySettings())
    missing = {"devices": ["coap://h"], "credentials": [{"uri": "coap://h/*", "oscore": "/nowhere"}]}
    with pytest.raises(UsageError, match=r"no settings\.json"):
        CoapGateway.check(CoapGatewaySettings.model_validate(missing))
    key = {"devices": ["coaps://h"], "credentials": [{"uri": "coaps://h/*", "identity": "me", "key": "secret"}]}
    with pytest.raises(UsageError, match="DTLSSocket"):
        CoapGateway.check(CoapGatewaySettings.model_validate(key))


def test_a_gateway_needs_an_integration_that_describes_its_devices() -> None:
    """Without one, the start stopped with the name of a plug-in that nobody wrote."""
    problem = "no integration that describes CoAP devices is installed; install one or remove the gateway"
    with nullcontext() if has_plugin(SESSIONS, SESSION) else pytest.raises(UsageError, match=problem):
        CoapGateway.check(CoapGatewaySettings(devices=("coap://h",)))
