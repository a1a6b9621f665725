"""A new home: its file, and the way of its owner to the page, which asks for the rest."""

from __future__ import annotations

import json
from importlib.util import find_spec
from io import StringIO
from typing import TYPE_CHECKING, Final

from homebot.bridges.rosbridge.first_code import MINUTES
from homebot.errors import UsageError
from homebot.plugins import INSTALL_EXTRA
from homebot.support.addresses import is_loopback, parse_address
from homebot.support.own_addresses import own_addresses
from homebot.support.owner_token import make_owner_token

if TYPE_CHECKING:
    from pathlib import Path

    from homebot.cli.arguments import ServerHost

_HALF: Final = 4
"""Characters after which a person pauses in a code."""


def begin_home(file: Path, door: ServerHost | None, owner_file: Path) -> None:
    """Write *file* with the tables that a home needs before its page is opened, unless it is there.

    Args:
        door: Where it listens, which the file says too; others in the network come in by the owner's token alone.

    Raises:
        UsageError: A file cannot be written.
    """
    lines = ["# The home of this folder. Its page writes here, and so may you.", "[home]"]
    if all(find_spec(name) for name in ("zeroconf", "ifaddr")):
        lines += ["", "[gateways.mdns] # the devices that announce themselves in the network"]
    if door is not None:
        lines += ["", "[door]", f"host = {json.dumps(door.host)}", f"port = {door.port}"]
        lines += ["tls = true"] if door.has_tls else []
        if not is_loopback(door.host):
            secret = make_owner_token(owner_file).file.resolve()
            lines.append(f"token_file = {json.dumps(str(secret))} # has every right; screens get tokens of their own")
    try:
        with file.open("x", encoding="utf-8") as new:
            new.write("\n".join([*lines, ""]))
    except FileExistsError:
        return
    except OSError as exc:
        raise UsageError(f"{file} cannot be written: {exc.strerror}") from exc


def print_way_in(page: str, code: str) -> None:
    """Print how the owner gets to the *page*, whose address may stand for all of this computer's."""
    scheme, _, address = page.partition("://")
    host, _, port = address.rpartition(":")
    known = parse_address(host)
    if known is not None and known.is_unspecified:
        own = own_addresses()
        host = next((address if ":" not in address else f"[{address}]" for address in own), "127.0.0.1")
    url = f"{scheme}://{host}:{port}/"
    link = f"{url}#code={code}"
    print(f"\nYour home is set up on its page:  {link}")
    print(f"  or open {url} and give it the code {code[:_HALF]}-{code[_HALF:]}")
    print(f"  The code lets one screen in, once, within {MINUTES} minutes; the next start prints another.")
    if is_loopback(host):
        print("  A phone reaches this page after: homebot run --new --door 0.0.0.0:9090, in an empty folder.")
    else:
        print(qr_code(link))
    print(flush=True)


def qr_code(text: str) -> str:
    """Return the lines of a QR code; the way to one where it cannot be drawn."""
    try:
        import segno  # noqa: PLC0415 - an extra
    except ImportError:
        return f'  (A QR code needs {INSTALL_EXTRA}qr]".)'
    drawn = StringIO()
    segno.make(text, micro=False).terminal(out=drawn, compact=True)
    return drawn.getvalue()
