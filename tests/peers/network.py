"""Small networks of their own for tests: machines that are network namespaces, joined by a bridge.

What is sent there, multicast included, reaches no other network and no other test. Needs Linux, root and ``ip``.
"""

from __future__ import annotations

import ctypes
import itertools
import os
import shutil
import signal
import subprocess
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import DEVNULL, PIPE, STDOUT

import anyio
from anyio.abc import Process
from anyio.streams.text import TextReceiveStream
from tests.patience import PATIENCE

from homebot.support.isolation import only_cause

INTERFACE = "e0"
"""The interface of every machine to the network; name it: by default, libraries use all there are."""

_CLONE_NEWNET = 0x40000000
_count = itertools.count()


@dataclass(frozen=True)
class Machine:
    """One machine on a :class:`Lan`.

    Attributes:
        name: Its name there.
        namespace: Its network namespace, as ``ip netns`` calls it.
        address: Its IPv4 address, with which :data:`INTERFACE` can be named too.
    """

    name: str
    namespace: str
    address: str

    def command(self, *command: str) -> tuple[str, ...]:
        """Return the command line that runs *command* there, with a view of mounts of its own."""
        return ("ip", "netns", "exec", self.namespace, *command)

    @contextmanager
    def entered(self) -> Iterator[None]:
        """Let every socket that this thread makes inside the block be on that machine."""
        with Path("/proc/thread-self/ns/net").open() as before:
            with Path(f"/run/netns/{self.namespace}").open() as there:
                _set_namespace(there.fileno())
            try:
                yield
            finally:
                _set_namespace(before.fileno())

    async def run(self, *command: str) -> str:
        """Run *command* there until it ends by itself, and return what it printed."""
        done = await anyio.run_process(self.command(*command), stderr=STDOUT, check=False)
        return done.stdout.decode(errors="replace")

    @asynccontextmanager
    async def program(self, *command: str, ready: str = "") -> AsyncIterator[Program]:
        """Run *command* there inside the block; leaving it kills it, and whatever it has started.

        Args:
            command: The command line.
            ready: What it prints when it is ready; by default it is ready at once.
        """
        arguments = self.command(*command)
        started = await anyio.open_process(arguments, stdin=DEVNULL, stdout=PIPE, stderr=STDOUT, start_new_session=True)
        try:
            async with started as process, anyio.create_task_group() as tasks:
                program = Program(process)
                tasks.start_soon(program.read)
                try:
                    if ready:
                        await program.prints(ready)
                    yield program
                finally:
                    program.end(signal.SIGKILL)
                    tasks.cancel_scope.cancel()
        except BaseExceptionGroup as group:  # what comes out of the block is to come out as it is
            cause = only_cause(group)
            if cause is None:
                raise
            raise cause from cause.__cause__


@dataclass(frozen=True)
class Program:
    """A program that runs on a :class:`Machine`.

    Attributes:
        process: The process.
        printed: What it printed.
    """

    process: Process
    printed: list[str] = field(default_factory=list)
    _news: list[anyio.Event] = field(default_factory=lambda: [anyio.Event()])

    async def read(self) -> None:
        """Read what it prints, until it ends."""
        assert self.process.stdout is not None
        async for text in TextReceiveStream(self.process.stdout, errors="replace"):
            self.printed.append(text)
            self._news.append(anyio.Event())
            self._news.pop(0).set()

    async def prints(self, text: str, within: float = PATIENCE) -> str:
        """Wait until it has printed a line with *text*, and return all that it printed.

        Raises:
            TimeoutError: It does not in that many seconds; shows what it printed instead.
        """
        with anyio.move_on_after(within):
            while "\n" not in "".join(self.printed).partition(text)[2]:
                await self._news[0].wait()
            return "".join(self.printed)
        raise TimeoutError(f"{text!r} was not printed, but {''.join(self.printed)!r}")

    def end(self, how: signal.Signals = signal.SIGTERM) -> None:
        """Send it, and what it has started, the signal *how*; SIGKILL is a power failure."""
        try:
            os.killpg(self.process.pid, how)
        except ProcessLookupError:
            return  # it has ended


class Lan:
    """A network with any number of machines: 10.77.0.1 and so on.

    Args:
        prefix: What the names of its namespaces begin with.
    """

    def __init__(self, prefix: str) -> None:
        self._prefix = prefix
        self._switch = f"{prefix}lan"
        self._machines: list[Machine] = []
        _ip("netns", "add", self._switch)
        _ip("-n", self._switch, "link", "add", "br0", "type", "bridge", "mcast_snooping", "0")
        _ip("-n", self._switch, "link", "set", "br0", "up")

    def machine(self, name: str) -> Machine:
        """Return a new machine on it."""
        number = len(self._machines) + 1
        machine = Machine(name, f"{self._prefix}{name}", f"10.77.0.{number}")
        space, port = machine.namespace, f"port{number}"
        _ip("netns", "add", space)
        self._machines.append(machine)
        _ip("-n", self._switch, "link", "add", port, "type", "veth", "peer", "name", INTERFACE, "netns", space)
        _ip("-n", self._switch, "link", "set", port, "master", "br0", "up")
        _ip("-n", space, "addr", "add", f"{machine.address}/24", "dev", INTERFACE)
        _ip("-n", space, "link", "set", "lo", "up")
        _ip("-n", space, "link", "set", INTERFACE, "up")
        _ip("-n", space, "route", "add", "default", "dev", INTERFACE)
        return machine

    def unplug(self, machine: Machine) -> None:
        """Take the cable out of *machine*."""
        _ip("-n", self._switch, "link", "set", f"port{self._machines.index(machine) + 1}", "down")

    def plug(self, machine: Machine) -> None:
        """Put the cable back into *machine*."""
        _ip("-n", self._switch, "link", "set", f"port{self._machines.index(machine) + 1}", "up")

    def close(self) -> None:
        """Take it down."""
        for space in (*(one.namespace for one in self._machines), self._switch):
            subprocess.run(["ip", "netns", "del", space], check=False, stdout=DEVNULL, stderr=DEVNULL)


def why_no_lan() -> str:
    """Return why there can be no :class:`Lan` on this computer; empty where there can be."""
    if shutil.which("ip", path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin") is None:
        return "ip is not installed (apt-get install iproute2)"
    if os.geteuid() != 0:
        return "network namespaces need root"
    probe = f"{new_prefix()}probe"
    made = subprocess.run(["ip", "netns", "add", probe], check=False, capture_output=True, text=True)
    if made.returncode:
        return f"there are no network namespaces: {made.stderr.strip()}"
    subprocess.run(["ip", "netns", "del", probe], check=False, capture_output=True)
    return ""


def new_prefix() -> str:
    """Return a prefix for the names of namespaces that no other test uses."""
    return f"hb{os.getpid()}-{next(_count)}-"


def missing_programs(*programs: str) -> str:
    """Return which of *programs* are not installed, as text; empty for none."""
    path = f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"
    return ", ".join(one for one in programs if shutil.which(one, path=path) is None)


def _ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True, capture_output=True, timeout=PATIENCE)


def _set_namespace(descriptor: int) -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.setns(descriptor, _CLONE_NEWNET):
        number = ctypes.get_errno()
        raise OSError(number, f"setns: {os.strerror(number)}")
