"""Question to a phone in the network of the house, without any right that needs root."""

import errno
import socket
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Final, TypeAlias

import anyio

Ping: TypeAlias = Callable[[str], Awaitable[bool | None]]
"""Returns whether an address answers; None if there is no network to ask in."""

_WITHIN: Final = 2.0
"""Seconds; a sleeping phone wakes every few hundred milliseconds."""

_PORT: Final = 62078
"""Open on iPhones; any other phone refuses it at once, which is an answer too."""

_NO_NETWORK: Final = frozenset({errno.ENETUNREACH, errno.ENETDOWN})
_REFUSED: Final = frozenset({errno.ECONNREFUSED, errno.ECONNRESET})


async def answers(address: str) -> bool | None:
    """Ask by a connection; see :data:`Ping`."""
    try:
        with anyio.fail_after(_WITHIN):
            stream = await anyio.connect_tcp(address, _PORT)
    except TimeoutError:
        return False
    except socket.gaierror:
        return None
    except OSError as exc:
        errnos = {error.errno for error in _errors(exc)}
        return True if errnos & _REFUSED else None if errnos & _NO_NETWORK else False
    with suppress(OSError):
        await stream.aclose()
    return True


def _errors(exc: BaseException) -> list[OSError]:
    """Return the errors of all addresses of a name, which anyio gathers in the cause."""
    inner = exc.__cause__
    group = inner.exceptions if isinstance(inner, BaseExceptionGroup) else (inner,)
    return [error for error in (exc, *group) if isinstance(error, OSError)]
