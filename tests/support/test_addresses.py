"""Which addresses are this computer's own, and which belong to one owner."""

import pytest

from homebot.support.addresses import ip_version, is_loopback, network_of


@pytest.mark.parametrize(
    ("host", "version"),
    [("127.0.0.1", 4), ("::1", 6), ("fe80::1%eth0", 6), ("hub.lan", None), ("1.2.3", None), ("", None)],
)
def test_an_address_needs_no_look_up_and_a_name_does(host: str, version: int | None) -> None:
    assert ip_version(host) == version


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "[::1]", "localhost", "LocalHost.", "127.8.8.8"])
def test_this_computer_is_loopback(host: str) -> None:
    assert is_loopback(host)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "hub.lan", "", "127.0.0.1.example.org"])  # noqa: S104 - the case under test
def test_what_others_can_reach_is_not(host: str) -> None:
    assert not is_loopback(host)


@pytest.mark.parametrize(
    ("host", "network"),
    [
        ("192.168.1.7", "192.168.1.7"),
        ("::1", "::/64"),
        ("fe80::1:2%eth0", "fe80::/64"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("::ffff:10.0.0.5", "10.0.0.5"),
        ("memory", "memory"),
        ("", ""),
    ],
)
def test_a_network_is_what_one_owner_has(host: str, network: str) -> None:
    assert network_of(host) == network
