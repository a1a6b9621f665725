"""Settings of the door: its address, whom it lets in, and how much one client may hold."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from homebot.bridges.access_settings import AccessSettings, Count

__all__ = ["DoorSettings"]


class DoorSettings(AccessSettings):
    """The settings of the door.

    Attributes:
        max_frame_bytes: Largest frame taken from a client; a larger one closes its connection.
        queue_depth: Messages of one topic that may wait for a slow client (on a keyed topic: of each key); then the
            oldest is dropped and counted.
        max_waiting_bytes: Bytes of messages that may wait for one slow client; then the oldest of the topic that brings
            more is dropped and counted.
        max_waiting_bytes_of_all: Bytes of messages that may wait for all clients together; above it the client for
            which most waits loses its oldest.
        max_entities: Topics and services that one client may use at a time; each id of a request counts.
        max_entities_of_all: Topics and services that all clients may use together.
        max_frames_per_second: Frames that one client may send on average; one that sends more is read more slowly.
        stall_timeout: Seconds after which a client that takes no bytes is cut off.
        max_calls: Service calls of one client under way at a time; one more fails at once.
    """

    port: Annotated[int, Field(ge=0, le=65535)] = 9090
    max_frame_bytes: Count = 1_048_576
    queue_depth: Count = 1000
    max_waiting_bytes: Count = 8_388_608
    max_waiting_bytes_of_all: Count = 33_554_432
    max_entities: Count = 1000
    max_entities_of_all: Count = 10_000
    max_frames_per_second: Count = 1000
    max_calls: Count = 100
    stall_timeout: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 60.0
