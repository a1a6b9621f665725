"""The limits on memory and waiting times of the broker, each with its overflow rule."""

from dataclasses import dataclass, fields

from homebot.errors import UsageError
from homebot.mqtt.packets import MAX_PACKET_SIZE

_MIB = 1024 * 1024


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class BrokerLimits:
    """The limits of one broker; sizes in bytes, times in seconds, all above 0.

    Attributes:
        max_connections: Clients that are connected, or have left messages to forward; one more is refused (0x97). Twice
            as many sockets may be open; beyond that the oldest closing one is cut, or else the new one.
        max_sessions: Sessions, connected or not; one more displaces the one left longest ago.
        max_subscriptions: Subscriptions of one session; one more is refused (0x97). homebot's gateway needs one for
            each topic on which devices publish their state.
        max_all_subscriptions: Subscriptions of all sessions; likewise.
        max_shared_subscriptions: Shared subscriptions of all sessions; likewise.
        max_filter_levels: Levels of all filters, where common first levels count once; likewise.
        max_filter_text: Length of all filters; likewise.
        max_topic_levels: Levels of a topic or filter; a deeper one is refused (0x90, 0x8F).
        max_packet_size: The largest accepted packet; a larger one ends the connection (0x95).
        max_control_size: The largest accepted packet other than CONNECT and PUBLISH; likewise.
        max_connect_size: The largest accepted CONNECT, a bound on memory before authentication.
        max_waiting_logins: Connections that have not logged in; one more ends the oldest of the host with the most.
        max_unread_login_bytes: Bytes of incomplete packets on all these connections; beyond it the one incomplete for
            longest is closed. There is room for at least one CONNECT of the largest size.
        max_unread_bytes: The same for logged-in connections, and for one packet of the largest size.
        max_inflight: Unacknowledged QoS 1 and 2 messages sent to a client; the client may ask for fewer.
        receive_maximum: Unanswered QoS 1 and 2 messages from a client; one more from an MQTT 5 client ends its
            connection (0x93).
        topic_alias_maximum: Topic aliases in each direction of a connection.
        max_queued_messages: Messages waiting for one client. While it is away the oldest is dropped; while it is
            connected but slow, publishers are held back from three quarters of the limit.
        max_queued_bytes: The same in bytes of topic, payload and properties.
        max_all_queued_bytes: Bytes of all waiting messages, each counted once; beyond it the session with the most
            loses its connection first, then its oldest messages.
        max_all_unsent_bytes: Bytes waiting for all sockets; beyond it the socket with the most is cut.
        max_will_bytes: Bytes of the wills of all clients; beyond it a client with a will above 1 KiB is refused (0x97).
        max_client_id: Characters of a client id; a client with a longer one is refused (0x85).
        max_alias_text: Characters of the topics to which a client has given aliases; more end its connection (0x97).
        hold_time: How long publishers are held back for a slow client; after that, further messages for it are refused
            (0x97) until it has caught up. Publishers before MQTT 5 cannot be refused and keep waiting; then a client
            that acknowledges fewer than max_inflight messages in this time is cut off (0x97).
        max_held_packets: Packets of a publisher that is held back; beyond it the socket is not read.
        max_held_bytes: The same in bytes of topic and payload.
        write_buffer: Bytes waiting for a client's socket, apart from one larger message; beyond it QoS 0 messages for
            it are dropped.
        max_retained_messages: Retained messages; one more is delivered but not retained (0x97).
        max_retained_bytes: The same in bytes of topic, payload and properties.
        connect_timeout: Longest time that a socket may be open without a CONNECT.
        linger: Time for which a connection closed after an error is drained, so that the peer can read the reason.
        stop_timeout: Longest wait for clients to close their side before they are cut.
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
        """Check the limits.

        Raises:
            UsageError: A limit is not above 0, or exceeds its field in MQTT.
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
    """Return the keep-alive interval to impose; None for none.

    Raises:
        UsageError: It is not from 1 to 65535.
    """
    if seconds is not None and not 1 <= seconds <= 65_535:
        raise UsageError(f"a keep-alive of {seconds} s is not from 1 to 65535")
    return seconds
