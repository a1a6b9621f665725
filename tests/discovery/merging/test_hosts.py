"""The services of one host are one device, unless the host runs the programs of several devices."""

from collections.abc import Callable, Iterable
from itertools import permutations

import pytest
from tests.discovery.announcements import announce, part_of

from homebot.conventions.dns_sd import FoundService, host_identifiers, identifiers_of, name_of
from homebot.devices import Sighting
from homebot.devices.part import Part
from homebot.discovery import DeviceIndex

Find = Callable[..., Sighting]


@pytest.fixture
def find() -> Find:
    """Makes the sighting of a service, as the gateway for mDNS publishes it."""

    def make(
        name: str, service_type: str, host: str, *parts: Part, gateway: str = "mdns", **properties: str
    ) -> Sighting:
        full = f"{service_type}.local."
        found = FoundService(f"{name}.{full}", name, full, host, 80, ("192.168.1.20",), properties)
        ids = (*identifiers_of(found), *host_identifiers(found))
        return announce(found.key, *parts, convention="", ids=ids, name=name_of(found), gateway=gateway, on="")

    return make


def devices(sightings: Iterable[Sighting]) -> list[list[str]]:
    """Return the announcements of each device, in whatever order they come."""
    orders = list(permutations(sightings))
    found = []
    for order in orders[:: max(1, len(orders) // 24)]:
        index = DeviceIndex(forget_after=1000.0)
        for one in order:
            index.observe(one)
        found.append(sorted(sorted(map(repr, entry.sources)) for one in index.ids if (entry := index.entry(one))))
    assert all(one == found[0] for one in found)
    return found[0]


def test_the_services_of_a_nas_are_one_device(find: Find) -> None:
    types = ("_ssh._tcp", "_smb._tcp", "_device-info._tcp")
    assert (
        len(
            devices(
                find("NAS", one, host)
                for one, host in zip(types, ("nas.local.", "NAS.local.", "nas.local."), strict=True)
            )
        )
        == 1
    )


def test_the_services_of_a_sonos_are_one_device(find: Find) -> None:
    """They name one hardware address, and each declares another serial number beside it."""
    host = "Sonos-949F3EC192E4.local."
    services = [
        find(
            "RINCON_949F3EC192E401400@Bath", "_sonos._tcp", "sonos949F3EC192E4.local.", uuid="RINCON_949F3EC192E401400"
        ),
        find("Bath", "_airplay._tcp", host, deviceid="94:9F:3E:C1:92:E4", serialnumber="94-9F-3E-C1-92-E4:3"),
        find("949F3EC192E4@Bath", "_raop._tcp", host),
        find("sonosRINCON_949F3EC192E401400", "_spotify-connect._tcp", host.lower(), sn="94-9F-3E-C1-92-E4:9"),
    ]
    assert len(devices(services)) == 1


def test_a_group_of_speakers_is_none_of_them(find: Find) -> None:
    host = "0a1b2c3d-4e5f-4071-8293-a4b5c6d7e8f9.local."
    group = find(
        "Google-Cast-Group-1111", "_googlecast._tcp", host, md="Google Cast Group", id="1" * 32, fn="Everywhere"
    )
    speaker = find("Nest-Mini-0a1b", "_googlecast._tcp", host, md="Nest Mini", id="2" * 32, fn="Kitchen")
    assert len(devices([group, speaker])) == 2


def test_a_lamp_and_its_page_are_one_device(find: Find) -> None:
    lamp = find("kitchen", "_esphomelib._tcp", "kitchen.local.", part_of("light", "on_off"), mac="a8032abe54dc")
    assert len(devices([lamp, find("kitchen", "_http._tcp", "kitchen.local.")])) == 1


def test_several_things_of_one_computer_are_several_devices(find: Find) -> None:
    """And its other services, beside them, are the computer."""
    things = [find(one, "_wot._tcp", "pi.local.", part_of("light", "on_off"), serial=f"{one}-0001") for one in "abc"]
    plain = [find(one, "_wot._tcp", "pi.local.", part_of("light", "on_off")) for one in "de"]
    computer = [find("pi", one, "pi.local.") for one in ("_ssh._tcp", "_http._tcp")]
    found = devices([*things[:2], plain[0], *computer])
    assert sorted(map(len, found)) == [1, 1, 1, 2]
    assert len(devices([*things, *plain])) == 5


def test_hosts_of_two_networks_are_two_devices(find: Find) -> None:
    """Each has a ``raspberrypi.local``."""
    host = "raspberrypi.local."
    assert len(devices([find("pi", "_ssh._tcp", host), find("pi", "_ssh._tcp", host, gateway="mdns_2")])) == 2


def test_two_hosts_with_one_serial_number_are_two_devices(find: Find) -> None:
    lamp = part_of("light", "on_off", id="l", writes=("x",))
    twins = [find(host, "_lamp._tcp", f"{host}.local.", lamp, serial="AB-4711-77") for host in ("desk", "hall")]
    assert len(devices(twins)) == 2
