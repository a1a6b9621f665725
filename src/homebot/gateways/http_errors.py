"""The errors of aiohttp, and the statuses of HTTP, as the three errors that callers know.

A helper of :mod:`homebot.gateways.http_client`.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import aiohttp

from homebot.conventions.payload import clean_text
from homebot.errors import BusyError, CertificateError, LinkError, RefusedError, WireError
from homebot.gateways.address_guard import OwnAddressError
from homebot.support.connect_errors import connect_problem

_LATER: Final = frozenset({408, 425, 429, 502, 503, 504})
_NO_ACCESS: Final = frozenset({401, 403, 407})


@contextmanager
def translated_errors(what: str, where: str, *, has_login: bool = False) -> Iterator[None]:
    """Turn the errors of aiohttp into ours; its own texts may hold addresses, so that few are shown."""
    try:
        yield
    except aiohttp.TooManyRedirects as exc:
        raise RefusedError(f"{what} {where}", "it redirects too often", exc.status) from None
    except aiohttp.WSServerHandshakeError as exc:
        if 200 <= exc.status < 300 or exc.status == 101:
            raise WireError(f"{where} opens no WebSocket as the rules say") from None
        check_status(f"{what} {where}", exc.status, has_login=has_login)
    except aiohttp.ClientResponseError as exc:
        raise WireError(f"{where} broke the rules of HTTP: {clean_text(exc.message, 80)}") from None
    except aiohttp.ClientConnectorCertificateError:
        raise CertificateError(f"the certificate of {where} is not trusted") from None
    except aiohttp.ClientSSLError as exc:
        raise LinkError(f"{where} cannot be reached with TLS: {type(exc).__name__}") from None
    except aiohttp.ClientConnectorError as exc:
        if isinstance(exc.os_error, OwnAddressError):
            raise exc.os_error.refusal_of(f"{what} {where}") from None
        raise LinkError(f"{where} cannot be reached: {connect_problem(exc.os_error)}") from None
    except (aiohttp.ClientConnectionError, aiohttp.ClientPayloadError, OSError):
        raise LinkError(f"the connection to {where} was lost") from None
    except ValueError:  # aiohttp.InvalidURL, of a redirect, or a host that no name server can be asked for
        raise WireError(f"{where} is no address of HTTP, or leads to what is none") from None
    except aiohttp.ClientError as exc:  # a challenge that the middleware for Digest does not understand
        raise WireError(f"{where} wants a password in an unknown way: {clean_text(str(exc), 80)}") from None


def check_status(what: str, status: int, *, has_login: bool = False) -> None:
    """Raise an error unless *status* is from 200 to 299.

    Raises:
        BusyError: It says that the request may work later.
        RefusedError: It is another; that is the code.
    """
    if 200 <= status < 300:
        return
    if status in _LATER:
        raise BusyError(f"{what}: the server answered {status}, it may work later")
    raise RefusedError(what, _reason(status, has_login=has_login), status)


def _reason(status: int, *, has_login: bool) -> str:
    if status not in _NO_ACCESS:
        return f"the server answered {status}"
    if not has_login:
        return f"it wants a password (status {status})"
    return f"it does not let homebot in with the password that is configured (status {status})"
