"""The certificate that a server showed when homebot was paired with it: it alone is trusted from then on.

For servers whose certificates no authority signed that computers know, or for names that no computer looks up.
"""

import ssl
from functools import partial
from typing import Final

import anyio.to_thread

from homebot.errors import LinkError
from homebot.gateways.http_address import parse_url, shown_url
from homebot.support.connect_errors import connect_problem

ANSWER_WITHIN: Final = 6.0


async def fetch_certificate(origin: str) -> str:
    """Return the certificate that a server shows, in PEM; raise LinkError if it cannot be reached."""
    url = parse_url(origin)
    fetch = partial(ssl.get_server_certificate, (url.host or "", url.port or 443), timeout=ANSWER_WITHIN)
    try:
        return await anyio.to_thread.run_sync(fetch)
    except OSError as exc:
        raise LinkError(f"{shown_url(url)} cannot be reached: {connect_problem(exc)}") from None


def only_certificate(certificate: str) -> ssl.SSLContext:
    """Return a context that trusts a server with this certificate, in PEM, and no other.

    Raises:
        OSError: It is no certificate.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN  # the authority of the server is not known here
    context.load_verify_locations(cadata=certificate)
    return context
