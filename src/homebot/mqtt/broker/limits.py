"""Limits on memory and waiting times of the broker: every bound in one place, with its overflow rule."""

from dataclasses import dataclass, fields

from homebot.errors import UsageError
from homebot.mqtt.packets import MAX_PACKET_SIZE

__all__ = ["BrokerLimits", "checked_keep_alive"]

_MIB = 1024 * 1024


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class BrokerLimits:
    """The bounds of one broker; sizes in bytes, times in seconds, all above 0.

    Attributes:
        max_connections: Clients connected at once, or gone with messages left to forward; one more is refused (0x97).
            Twice as many sockets may be open; one more costs the oldest that only waits for its end, or is closed.
        max_sessions: Sessions kept, connected or not; one more pushes out the one that was left longest ago.
        max_subscriptions: Subscriptions of one session; one more is refused (0x97). The gateway of homebot needs one
            for each topic that devices publish their state on.
        max_all_subscriptions: Subscriptions of all sessions; likewise.
        max_shared_subscriptions: Shared subscriptions of all sessions; likewise.
        max_filter_levels: Levels of all filters, those counted once that filters begin with alike; likewise.
        max_filter_text: The length of all filters; likewise.
        max_topic_levels: Levels of a topic or filter; a deeper one is refused (0x90, 0x8F).
        max_packet_size: The largest packet taken; a larger one ends the connection (0x95).
        max_control_size: The largest packet taken other than CONNECT and PUBLISH; likewise.
        max_connect_size: The largest accepted CONNECT, a bound on memory before authentication.
        max_waiting_logins: Connections that have not logged in; one more costs the oldest of the host that has most
            of them.
        max_unread_login_bytes: Bytes of incomplete packets on all of these together; beyond it the one incomplete
            longest loses its connection. At least one CONNECT of the largest size has room.
        max_unread_bytes: The same for connections that have logged in, and for one packet of the largest size.
        max_inflight: QoS 1 and 2 messages sent to a client and not acknowledged; the client may ask for less.
        receive_maximum: QoS 1 and 2 messages taken from a client and not answered; one more from an MQTT 5
            client ends its connection (0x93).
        topic_alias_maximum: Topic aliases in each direction of a connection.
        max_queued_messages: Messages waiting for one client. While it is away the oldest is dropped; while it
            is connected but slow, publishers are held back from three quarters of this on.
        max_queued_bytes: The same in bytes of topic, payload and properties.
        max_all_queued_bytes: Bytes of all messages that wait, a message that waits for many counted once; beyond it the
            session for which most waits loses: first its connection, then its oldest messages.
        max_all_unsent_bytes: Bytes waiting for all sockets; beyond it the socket for which most wait is cut.
        max_will_bytes: The wills of all clients; a client with one more of above 1 KiB is refused (0x97).
        max_client_id: Characters of a client id; a client with a longer one is refused (0x85).
        max_alias_text: Characters of all topics that a client has given aliases; beyond it its connection ends (0x97).
        hold_time: How long publishers are held back for a slow client; after that its share of further
            messages is refused (0x97) until it has caught up. Publishers before MQTT 5, which cannot be refused,
            wait on; a client that acknowledges less than max_inflight messages in this time is then cut off (0x97).
        max_held_packets: Packets of a publisher that is held back; beyond it the socket is not read.
        max_held_bytes: The same in bytes of topic and payload.
        write_buffer: Bytes waiting for a client's socket, besides one larger message; beyond it QoS 0 messages for
            it are dropped.
        max_retained_messages: Retained messages; one more is delivered but not retained (0x97).
        max_retained_bytes: The same in bytes of topic, payload and properties.
        connect_timeout: How long a socket may be open without a CONNECT.
        linger: How long a connection closed for an error is drained, so that the peer can read the reason.
        stop_timeout: How long stopping waits for the clients to close their side before it cuts them.
    """

    max_connections: int = 1000
    max_sessions: int = 2000
    max_subscriptions: int = 40_000
    max_all_subscriptions: int = 50_000
    max_shared_subscriptions: int = 1000
    max_filter_levels: int = 100_000
    max_filter_text: int = 8 * _MIB
    max_topic_levels: int = 128
    max_packet_size: int = 16 * _MIB
    max_control_size: int = _MIB // 4
    max_connect_size: int = _MIB // 4
    max_waiting_logins: int = 256
    max_unread_login_bytes: int = 4 * _MIB
    max_unread_bytes: int = 16 * _MIB
    max_inflight: int = 64
    receive_maximum: int = 1024
    topic_alias_maximum: int = 64
    max_queued_messages: int = 10_000
    max_queued_bytes: int = 16 * _MIB
    max_all_queued_bytes: int = 32 * _MIB
    max_all_unsent_bytes: int = 20 * _MIB
    max_will_bytes: int = 8 * _MIB
    max_client_id: int = 1024
    max_alias_text: int = 32 * 1024
    hold_time: float = 10.0
    max_held_packets: int = 1024
    max_held_bytes: int = 4 * _MIB
    write_buffer: int = 2 * _MIB
    max_retained_messages: int = 50_000
    max_retained_bytes: int = 32 * _MIB
    connect_timeout: float = 10.0
    linger: float = 1.0
    stop_timeout: float = 0.2

    def __post_init__(self) -> None:
        """Refuse bounds that cannot work.

        Raises:
            UsageError: A bound is not above 0, or larger than its field in MQTT.
        """
        for field in fields(self):
            if getattr(self, field.name) <= 0:
                raise UsageError(f"broker limit {field.name} must be above 0")
        for name in ("max_inflight", "receive_maximum", "topic_alias_maximum"):
            if getattr(self, name) > 65_535:
                raise UsageError(f"broker limit {name} must not be above 65535")
        if self.max_packet_size > MAX_PACKET_SIZE:
            raise UsageError(f"broker limit max_packet_size must not be above {MAX_PACKET_SIZE}")


def checked_keep_alive(seconds: int | None) -> int | None:
    """Return the keep-alive interval that a broker is to impose; None imposes none.

    Raises:
        UsageError: It is not from 1 to 65535.
    """
    if seconds is not None and not 1 <= seconds <= 65_535:
        raise UsageError(f"a keep-alive of {seconds} s is not from 1 to 65535")
    return seconds
