"""The registrations of a resource directory: what is taken, renewed, found and ended, and how many."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.coap.link_format import WebLink, parse_links
from homebot.conventions.coap.registry import MAX_LINKS_OF_ONE, MAX_PER_HOST, MAX_REGISTRATIONS, DirectoryRegistry
from homebot.errors import RefusedError, WireError

LINKS = parse_links(b'</on>;rt="light";ct=50;obs,</t>;rt="temperature-c";if=sensor')
HOST = "192.168.1.5"
BASE = f"coap://{HOST}"


def test_a_registration_is_found_until_it_ends() -> None:
    registry = DirectoryRegistry()
    made = registry.register({"ep": "lamp", "lt": "60", "d": "home"}, LINKS, HOST, BASE, 100.0)
    assert (made.path, made.endpoint.key, made.endpoint.lifetime) == ("/rd/1", "lamp@home", 60.0)
    (link,) = registry.look_up_endpoints({})
    assert (link.target, link.get("ep"), link.get("base"), link.get("rt")) == ("/rd/1", "lamp", BASE, "core.rd-ep")
    assert registry.expire(159.9) == ()
    assert [one.path for one in registry.expire(160.0)] == ["/rd/1"]
    assert registry.look_up_endpoints({}) == ()


def test_a_link_that_is_no_address_is_refused_and_does_not_end_the_lookup() -> None:
    registry = DirectoryRegistry()
    with pytest.raises(WireError, match="is not an address"):
        registry.register({"ep": "lamp"}, (WebLink("//["),), HOST, BASE, 0.0)
    assert registry.look_up_resources({}) == ()


def test_renewing_gives_a_new_lifetime_and_registering_again_replaces() -> None:
    registry = DirectoryRegistry()
    path = registry.register({"ep": "lamp", "lt": "60"}, LINKS, HOST, BASE, 0.0).path
    registry.renew(path, {"lt": "100"}, HOST, 50.0)
    assert registry.expire(149.0) == ()
    assert registry.register({"ep": "lamp"}, LINKS[:1], HOST, BASE, 60.0).path == path
    assert len(registry.look_up_resources({})) == 1
    assert registry.expire(60.0 + 89_999) == ()
    registry.remove(path, HOST)
    with pytest.raises(KeyError):
        registry.renew(path, {}, HOST, 0.0)
    with pytest.raises(KeyError):
        registry.remove(path, HOST)


@pytest.mark.parametrize(
    ("query", "count"),
    [
        ({}, 2),
        ({"rt": "light"}, 1),
        ({"rt": "temp*"}, 1),
        ({"if": "sensor"}, 1),
        ({"ep": "lamp"}, 2),
        ({"ep": "x"}, 0),
        ({"rt": "light", "if": "sensor"}, 0),
        ({"obs": ""}, 1),
        ({"count": "1"}, 1),
        ({"page": "1", "count": "1"}, 1),
        ({"page": "2", "count": "1"}, 0),
        ({"href": "/t"}, 1),
    ],
)
def test_resources_are_looked_up_by_their_attributes_or_those_of_their_endpoint(
    query: dict[str, str], count: int
) -> None:
    registry = DirectoryRegistry()
    registry.register({"ep": "lamp"}, LINKS, HOST, BASE, 0.0)
    found = registry.look_up_resources(query)
    assert len(found) == count
    assert all(one.target.startswith(BASE) for one in found)


def test_endpoints_are_looked_up_by_their_resources_as_well() -> None:
    registry = DirectoryRegistry()
    registry.register({"ep": "lamp"}, LINKS, HOST, BASE, 0.0)
    registry.register({"ep": "other"}, (), HOST, "coap://192.168.1.5:5684", 0.0)
    assert [one.get("ep") for one in registry.look_up_endpoints({"rt": "light"})] == ["lamp"]
    with pytest.raises(WireError, match="whole numbers"):
        registry.look_up_endpoints({"page": "x"})


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ({}, "ep is missing"),
        ({"ep": "a", "lt": "0"}, "lt '0' is not a number from 1"),
        ({"ep": "a", "lt": "x"}, "lt 'x'"),
        ({"ep": "a", "lt": "99999999999999"}, "is not a number from 1"),
        ({"ep": "a", "base": "http://h"}, "no usable base"),
        ({"ep": "a" * 201}, "too long"),
        ({"ep": "a\n"}, "control characters"),
        ({"ep": "a", **{str(number): "" for number in range(30)}}, "more than 20 parameters"),
    ],
)
def test_an_invalid_registration_is_refused(parameters: dict[str, str], problem: str) -> None:
    registry = DirectoryRegistry()
    with pytest.raises(WireError, match=problem):
        registry.register(parameters, (), HOST, BASE, 0.0)
    path = registry.register({"ep": "lamp"}, (), HOST, BASE, 0.0).path
    with pytest.raises(WireError, match="cannot be changed"):
        registry.renew(path, {"ep": "b"}, HOST, 0.0)
    with pytest.raises(WireError, match="links are too many"):
        registry.register({"ep": "b"}, (WebLink("/x"),) * (MAX_LINKS_OF_ONE + 1), HOST, BASE, 0.0)


def test_a_flood_is_bounded_by_its_host_and_in_all_and_known_ones_can_renew() -> None:
    registry = DirectoryRegistry()
    for number in range(10_000):
        with suppress(RefusedError):
            registry.register({"ep": f"fake{number}"}, (), "10.0.0.66", f"coap://10.0.0.66:{number + 1}", 0.0)
    assert len(registry.look_up_endpoints({})) == MAX_PER_HOST
    assert registry.refused == 10_000 - MAX_PER_HOST
    made = registry.register({"ep": "lamp"}, LINKS, "10.0.0.5", "coap://10.0.0.5", 0.0)
    for number in range(10_000):
        with suppress(RefusedError):
            registry.register(
                {"ep": f"other{number}"},
                (),
                f"10.2.{number % 250}.{number // 250}",
                f"coap://10.2.{number % 250}.{number // 250}",
                0.0,
            )
    assert len(registry.look_up_endpoints({})) == MAX_REGISTRATIONS
    assert registry.register({"ep": "lamp"}, LINKS, "10.0.0.5", "coap://10.0.0.5", 1.0).path == made.path
    registry.expire(1e12)
    assert registry.register({"ep": "again"}, (), "10.0.0.66", "coap://10.0.0.66", 1e12).endpoint.key == "again"


def test_a_registration_is_changed_and_ended_by_its_host_alone_until_it_ends() -> None:
    """Else whoever is on the network gets the commands of any device that registers."""
    registry = DirectoryRegistry()
    path = registry.register({"ep": "lamp", "lt": "60"}, LINKS, "10.0.0.5", "coap://10.0.0.5", 0.0).path
    with pytest.raises(RefusedError, match="another host's"):
        registry.register({"ep": "lamp"}, LINKS, "10.0.0.66", "coap://10.0.0.66", 1.0)
    with pytest.raises(RefusedError, match="another host's"):
        registry.renew(path, {"base": "coap://10.0.0.66"}, "10.0.0.66", 1.0)
    with pytest.raises(RefusedError, match="another host's"):
        registry.remove(path, "10.0.0.66")
    (link,) = registry.look_up_endpoints({})
    assert link.get("base") == "coap://10.0.0.5"
    registry.expire(60.0)
    assert registry.register({"ep": "lamp"}, LINKS, "10.0.0.66", "coap://10.0.0.66", 60.0).source == "10.0.0.66"


@pytest.mark.parametrize(
    ("source", "base"),
    [
        ("10.0.0.66", "coap://10.0.0.5"),
        ("10.0.0.66", "coap://127.0.0.1"),
        ("10.0.0.66", "coap://[::ffff:10.0.0.5]"),
        ("10.0.0.66", "coap://lamp.local"),
        ("fe80::66%eth0", "coap://[fe80::66%25eth1]"),
    ],
)
def test_a_registration_speaks_for_its_own_address(source: str, base: str) -> None:
    """Else one host takes over the device of another, with the first registration or when it renews its own."""
    registry, own = DirectoryRegistry(), f"coap://{'[' + source.replace('%', '%25') + ']' if ':' in source else source}"
    with pytest.raises(RefusedError, match="speaks for its own address"):
        registry.register({"ep": "lamp", "base": base}, LINKS, source, own, 0.0)
    path = registry.register({"ep": "lamp", "base": f"{own}:5700"}, LINKS, source, own, 0.0).path
    with pytest.raises(RefusedError, match="speaks for its own address"):
        registry.renew(path, {"base": base}, source, 1.0)
    assert registry.look_up_endpoints({})[0].get("base") == f"{own}:5700"


def test_a_program_on_this_computer_registers_other_hosts() -> None:
    """It is a commissioning tool of RFC 9176, section 5."""
    made = DirectoryRegistry().register({"ep": "lamp", "base": BASE}, LINKS, "127.0.0.1", "coap://127.0.0.1", 0.0)
    assert made.endpoint.base == BASE


def test_a_registered_name_is_no_address_of_another_device() -> None:
    """The keys of devices without a name are addresses, and those of further devices lie below the first one's."""
    name = "coap://10.0.0.5/lamp"
    made = DirectoryRegistry().register({"ep": name}, LINKS, "10.0.0.66", "coap://10.0.0.66", 0.0)
    assert "/" not in made.endpoint.key


@given(st.dictionaries(st.sampled_from(["ep", "lt", "base", "d", "rt"]) | st.text(max_size=5), st.text(max_size=20)))
def test_any_parameters_are_a_registration_or_a_clear_error(parameters: dict[str, str]) -> None:
    registry = DirectoryRegistry()
    with suppress(WireError, RefusedError):
        assert registry.register(parameters, LINKS, HOST, BASE, 0.0).endpoint.base
    with suppress(WireError):
        registry.look_up_endpoints(parameters)
