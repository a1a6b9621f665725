"""The service by which a client fetches the lines of a recording."""

from __future__ import annotations

from homebot.messages.message import Message, ServiceType

__all__ = ["ReadRecording", "ReadRecordingRequest", "ReadRecordingResponse"]


class ReadRecordingRequest(Message):
    """A request for the next lines; it waits up to a second for some.

    Attributes:
        is_last: Whether to end the recording; ask again until it is over.
    """

    is_last: bool = False


class ReadRecordingResponse(Message):
    """Lines, which are forgotten then.

    Attributes:
        lines: The lines, in order, without their ends.
        is_over: Whether these were the last.
    """

    lines: tuple[str, ...] = ()
    is_over: bool = False


ReadRecording = ServiceType("homebot/srv/ReadRecording", ReadRecordingRequest, ReadRecordingResponse)
