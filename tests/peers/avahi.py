"""Avahi, the mDNS of most Linux systems, on a machine of a test's network."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from tests.peers.network import INTERFACE, Machine, Program, missing_programs

_START = """
set -e
mount -t tmpfs tmpfs /run
mkdir -p /run/dbus /run/avahi-daemon
cat > /run/avahi.conf <<END
[server]
host-name=$1
use-ipv6=no
allow-interfaces=$2
[publish]
publish-workstation=no
END
shift 2
dbus-daemon --system --nofork --nopidfile &
until [ -S /run/dbus/system_bus_socket ]; do sleep 0.05; done
avahi-daemon --no-drop-root --no-rlimits --no-chroot -f /run/avahi.conf &
call='--print-reply=literal --dest=org.freedesktop.DBus / org.freedesktop.DBus.NameHasOwner'
until dbus-send --system $call string:org.freedesktop.Avahi | grep -q true; do sleep 0.05; done
exec "$@"
"""
"""Both daemons have their files in /run, so that it must be one of their own.

The daemon's own check succeeds before its programs can reach it: they would end with "Daemon not running".
"""


def why_no_avahi() -> str:
    """Return why Avahi cannot be used here; empty where it can."""
    missing = missing_programs("avahi-daemon", "avahi-publish", "avahi-browse", "dbus-daemon")
    return f"not installed: {missing} (apt-get install avahi-daemon avahi-utils dbus)" if missing else ""


@asynccontextmanager
async def avahi(machine: Machine, *command: str, ready: str = "") -> AsyncIterator[Program]:
    """Run Avahi's daemon, with *command* that uses it, on *machine* inside the block.

    The program is *command*; SIGTERM ends it with a goodbye of the daemon, SIGKILL ends both without.

    Args:
        machine: Where; it is called so in mDNS too.
        command: ``avahi-publish`` or ``avahi-browse``, with arguments.
        ready: What it prints when it is ready.
    """
    async with machine.program("sh", "-c", _START, "sh", machine.name, INTERFACE, *command, ready=ready) as program:
        yield program
