"""HTTP requests with a body or other methods than GET, which the WebSocket library does not read, by h11.

A request is read completely, within limits, and its head is passed to the library as that of a GET, so that clients are
admitted and answered in one place.
"""

from typing import Final, final

import h11

from homebot.errors import WireError

MAX_BYTES: Final = 65_536
"""Most bytes of a body."""

_MAX_OF_HEAD: Final = 16_384
_OF_THE_BODY: Final = frozenset(
    {b"connection", b"content-length", b"expect", b"transfer-encoding", b"trailer", b"upgrade"}
)


@final
class PostedRequest:
    """A request being received."""

    def __init__(self) -> None:
        self.method = ""
        self.content_type = ""
        self.body = b""
        self._http = h11.Connection(h11.SERVER, max_incomplete_event_size=_MAX_OF_HEAD)
        self._head: h11.Request | None = None

    def receive(self, data: bytes) -> bytes:
        """Return the head for the library once *data* completes the request; otherwise nothing."""
        if self.method:
            return b""
        try:
            self._http.receive_data(data)
            while not isinstance(event := self._http.next_event(), type):
                if isinstance(event, h11.Request):
                    self._head = event
                elif isinstance(event, h11.Data):
                    if len(self.body) + len(event.data) > MAX_BYTES:
                        raise WireError(f"the body of an HTTP request has more than {MAX_BYTES:,} bytes")
                    self.body += event.data
                elif isinstance(event, h11.EndOfMessage):
                    head = self._head
                    if head is None:
                        raise WireError("the HTTP request has no head")
                    self.method = head.method.decode()
                    self.content_type = dict(head.headers).get(b"content-type", b"").decode("latin-1")
                    lines = (b"%s: %s\r\n" % (name, value) for name, value in head.headers if name not in _OF_THE_BODY)
                    return b"GET %s HTTP/1.1\r\n%s\r\n" % (head.target, b"".join(lines))
        except h11.RemoteProtocolError as exc:
            problem = str(exc).partition(": b")[0]  # without the line, which may contain a token
            raise WireError(f"the HTTP request is wrong: {problem}") from exc
        return b""

    @property
    def is_reading(self) -> bool:
        """True for GET, and for HEAD (its answer has no body)."""
        return self.method in {"GET", "HEAD"}

    @property
    def waits_for_go_ahead(self) -> bool:
        """True if the client sends its body only after ``100 Continue``."""
        return self._http.they_are_waiting_for_100_continue
