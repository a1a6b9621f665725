"""A host lists addresses of this computer and of others, over HTTP and CoAP, from a machine of its own."""

import json
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest
from tests.patience import PATIENCE
from tests.peers.network import INTERFACE, Lan, Machine, new_prefix, why_no_lan
from tests.system.attack_probe import ROOT, Attacked, attacked, until
from tests.system.lying_network import DIRECTORY_PORT
from tests.turns import slowness
from websockets.sync.client import connect

from homebot.gateways.address_guard import AddressGuard, OwnAddressError

pytestmark = pytest.mark.system

LONGEST_TURN = 0.1
"""Seconds of the processor."""


@pytest.fixture
def machines() -> Iterator[tuple[Machine, Machine, Machine]]:
    """The machine of homebot, on which this thread is, and those of the liar and of the victim."""
    if problem := why_no_lan():
        pytest.skip(problem)
    lan = Lan(new_prefix())
    try:
        hub, liar, victim = (lan.machine(name) for name in ("hub", "liar", "victim"))
        with hub.entered():
            yield hub, liar, victim
    finally:
        lan.close()


@contextmanager
def canaries() -> Iterator[tuple[int, Callable[[], int]]]:
    """Listen for connections and datagrams at one port of all addresses; yield it, and what counts them."""
    with ExitStack() as stack:
        tcp = stack.enter_context(socket.create_server(("::", 0), family=socket.AF_INET6, dualstack_ipv6=True))
        port: int = tcp.getsockname()[1]
        udp = stack.enter_context(socket.socket(socket.AF_INET6, socket.SOCK_DGRAM))
        udp.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
        udp.bind(("::", port))
        tcp.setblocking(False)
        udp.setblocking(False)

        def count() -> int:
            found = 0
            for come in (tcp.accept, lambda: udp.recv(2000)):
                with suppress(BlockingIOError):
                    come()
                    found += 1
            return found

        yield port, count


def listed(homebot: Attacked) -> dict[str, str]:
    """Return the devices of the directory: names by id."""
    with connect(homebot.url, proxy=None, compression=None, open_timeout=PATIENCE) as door:
        door.send(json.dumps({"op": "call_service", "id": "f", "service": "/discovery/find_devices", "args": {}}))
        while (answer := json.loads(door.recv(timeout=PATIENCE))).get("id") != "f":
            pass
    return {one["id"]: one["name"] for one in answer["values"]["devices"]}


@contextmanager
def program(machine: Machine, folder: Path, role: str, *arguments: str) -> Iterator[Callable[[], str]]:
    """Run a role of the lying network on *machine*; yield what returns its output."""
    output = folder / f"{role}.txt"
    command = machine.command(sys.executable, "-m", "tests.system.lying_network", role, *arguments)
    with output.open("wb") as out, subprocess.Popen(command, stdout=out, stderr=out, cwd=ROOT) as process:
        try:
            yield lambda: output.read_text(encoding="utf-8")
        finally:
            process.kill()


def test_what_a_host_lists_leads_neither_to_this_computer_nor_to_the_devices_of_others(
    tmp_path: Path, machines: tuple[Machine, Machine, Machine]
) -> None:
    hub, liar, victim = machines
    with canaries() as (port, count):
        hosts = ("127.0.0.1", "127.1", "0x7f.1", "0.0.0.0", "localhost", socket.gethostname(), hub.address)  # noqa: S104
        lies = [f"{one}:{port}" for one in (*hosts, "[::1]", "[::]", "[::ffff:127.0.0.1]", f"[::ffff:{hub.address}]")]
        (tmp_path / "homebot.toml").write_text(
            f"""
            [gateways.coap]
            devices = ["coap://{victim.address}"]
            resource_directory = ["coap://{liar.address}"]

            [gateways.thing_directory]
            url = "http://{liar.address}:{DIRECTORY_PORT}"
            """,
            encoding="utf-8",
        )
        arguments = (liar.address, *lies)
        with program(victim, tmp_path, "victim", victim.address), attacked(tmp_path) as homebot:
            until(lambda: "Victim" in listed(homebot).values() or None, PATIENCE)
            with program(liar, tmp_path, "liar", *arguments) as printed:
                until(lambda: "has lied" in printed() or None, PATIENCE)
                names = {"Victim", "Honest", "Honest CoAP"}
                until(lambda: names <= set(listed(homebot).values()) or None, PATIENCE)
                until(lambda: "leads to this computer" in homebot.text() or None, PATIENCE)
                known = listed(homebot)
            toll = homebot.toll()
        print(f"\n{len(lies)} lies over HTTP and over CoAP: {toll}")
        assert count() == 0
        assert {one for one in known.values() if one in names} == names
        assert toll.busy < LONGEST_TURN * slowness()


def test_an_address_is_of_this_computer_where_the_kernel_delivers_it_here(
    machines: tuple[Machine, Machine, Machine],
) -> None:
    """As on a router: with anycast addresses, whole networks of its own, and sockets bound to any address."""
    hub, liar, _ = machines
    for command in (
        f"ip addr add 10.77.0.50/24 dev {INTERFACE}",
        f"ip addr add fd00:77::1/64 dev {INTERFACE} nodad",
        "ip -6 route add local fd00:99::/64 dev lo",
        "sysctl -qw net.ipv6.conf.all.forwarding=1 net.ipv4.ip_nonlocal_bind=1 net.ipv6.ip_nonlocal_bind=1",
    ):
        subprocess.run(hub.command(*command.split()), check=True)
    own = ("10.77.0.50", "fd00:77::1", "fd00:77::", "fd00:99::5")
    with canaries() as (port, count), socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as sender:
        for host in own:
            sender.sendto(b"reached", (f"::ffff:{host}" if "." in host else host, port))
            assert count() == 1, host
    for host in (*own, f"64:ff9b::{hub.address}"):
        with pytest.raises(OwnAddressError):
            AddressGuard().check((host, 80))
    for host in (liar.address, "fd00:77::2", "192.0.2.1", "64:ff9b::c000:201"):
        assert AddressGuard().check((host, 80)) == host
