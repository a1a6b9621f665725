"""The network of the tests carries multicast between its machines, and to nobody else."""

import socket

import anyio
import pytest
from tests.patience import PATIENCE
from tests.peers.network import INTERFACE, Lan, Machine

from homebot.gateways.address_guard import AddressGuard, OwnAddressError

GROUP, PORT = "224.0.0.251", 5353
SAY = f"""
import socket
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.sendto(b"here", ("{GROUP}", {PORT}))
"""


def listener(machine: Machine) -> socket.socket:
    heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    heard.bind(("", PORT))
    group = socket.inet_aton(GROUP) + socket.inet_aton(machine.address)
    heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
    heard.settimeout(PATIENCE)
    return heard


async def test_multicast_reaches_the_other_machines(lan: Lan, hub: Machine) -> None:
    device = lan.machine("device")
    with listener(hub) as heard:
        await device.run("python3", "-c", SAY)
        assert heard.recvfrom(100) == (b"here", (device.address, pytest.approx(40_000, abs=40_000)))


async def test_a_machine_that_is_unplugged_is_not_heard(lan: Lan, hub: Machine) -> None:
    device = lan.machine("device")
    lan.unplug(device)
    with listener(hub) as heard:
        await device.run("python3", "-c", SAY)
        heard.settimeout(0.2)
        with pytest.raises(TimeoutError):
            heard.recvfrom(100)


async def test_two_networks_do_not_hear_each_other(lan: Lan, hub: Machine) -> None:
    elsewhere = Lan("hbelse-")
    try:
        with listener(hub) as heard:
            await elsewhere.machine("device").run("python3", "-c", SAY)
            heard.settimeout(0.2)
            with pytest.raises(TimeoutError):
                heard.recvfrom(100)
    finally:
        elsewhere.close()


async def test_a_program_on_a_machine_is_heard_and_ends_with_the_block(lan: Lan) -> None:
    device = lan.machine("device")
    async with device.program("sh", "-c", "echo is ready; sleep 1000", ready="ready") as program:
        assert program.printed == ["is ready\n"]
    with anyio.fail_after(PATIENCE):
        assert await program.process.wait() != 0


async def test_what_a_program_does_not_print_is_an_error_that_shows_what_it_printed(lan: Lan) -> None:
    device = lan.machine("device")
    async with device.program("sh", "-c", "echo no; sleep 1000", ready="no") as program:
        with pytest.raises(TimeoutError, match="'yes' was not printed, but 'no"):
            await program.prints("yes", within=0.5)


@pytest.mark.parametrize("second", ["{0}1", "192.168.7.9"])
async def test_a_second_address_of_this_computer_is_not_led_to(hub: Machine, second: str) -> None:
    """The kernel sends from the first address of a network, also to the second one."""
    address = second.format(hub.address)
    await hub.run("ip", "addr", "add", f"{address}/24", "dev", INTERFACE)
    with hub.entered(), pytest.raises(OwnAddressError):
        AddressGuard().check((address, 0))
    with hub.entered():
        assert AddressGuard().check(("192.168.7.8", 0)) == "192.168.7.8"
