"""The broker's answer to a CONNECT. No I/O."""

from math import inf
from typing import NamedTuple

from homebot.mqtt.broker.authentication import Applicant, host_of
from homebot.mqtt.broker.sessions import will_size
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.packets import (
    MAX_PACKET_SIZE,
    Connack,
    Connect,
    Properties,
    ProtocolVersion,
    ReasonCode,
    encode,
)

_SMALL_WILL = 1024  # bytes; smaller wills are not worth counting
_NEVER = 0xFFFF_FFFF
_DEFAULT_RECEIVE_MAXIMUM = 65_535


class ConnectRequest(NamedTuple):
    """A client's CONNECT, completed by the protocol's defaults.

    Attributes:
        expiry: Seconds for which its session outlives the connection; may be infinite.
        keep_alive: The longest silence in seconds; 0 is no limit.
        receive_maximum: Most unanswered QoS 1 and 2 messages for the client.
        max_packet_size: The largest packet that it accepts, in bytes.
    """

    client_id: str
    assigned: bool
    expiry: float
    keep_alive: int
    keep_alive_imposed: bool
    receive_maximum: int
    max_packet_size: int
    alias_maximum: int
    problem_information: bool


def may_try_at(connect: Connect, state: BrokerState, address: str) -> float:
    """Return when the password of *connect* may be checked, on the monotonic clock; often in the past."""
    applicant = _applicant(connect, state, address)
    if applicant is None:
        return 0.0
    is_wrong = state.authentication.check(connect.username, connect.password).failed
    return state.throttle.until(applicant, b"" if is_wrong else connect.password or b"")


def refusal(connect: Connect, state: BrokerState, address: str) -> ReasonCode:
    """Return the reason for refusing *connect*; success if it is accepted."""
    if connect.properties.authentication_method is not None:
        return ReasonCode.BAD_AUTHENTICATION_METHOD
    if connect.properties.authentication_data is not None:
        return ReasonCode.PROTOCOL_ERROR
    verdict = state.authentication.check(connect.username, connect.password)
    applicant = _applicant(connect, state, address)
    if applicant is not None and verdict.failed:
        state.counters.logins_failed += 1
        failures, delay = state.throttle.failed(applicant)
        if delay:
            state.warn(
                "broker.logins_slowed",
                f"{failures} wrong passwords came from {applicant.host}; the next attempt is answered after "
                f"{delay:g} s",
                host=applicant.host,
                failures=failures,
                delay=delay,
            )
    elif applicant is not None:
        state.throttle.succeeded(applicant)
    if verdict.failed:
        return verdict
    if not _is_client_id(connect, state):
        return ReasonCode.CLIENT_IDENTIFIER_NOT_VALID
    if not _has_room(connect, state):
        return ReasonCode.QUOTA_EXCEEDED
    if not _can_be_welcomed(connect, state):
        return ReasonCode.PACKET_TOO_LARGE
    return ReasonCode.SUCCESS if connect.will is None else _will_refusal(connect.client_id, connect.will.topic, state)


def _will_refusal(client_id: str, topic: str, state: BrokerState) -> ReasonCode:
    if topic.count("/") >= state.limits.max_topic_levels:
        return ReasonCode.TOPIC_NAME_INVALID
    return state.policy.publish(client_id, topic)


def accept(connect: Connect, state: BrokerState) -> ConnectRequest:
    """Complete *connect* by default values."""
    properties = connect.properties
    is_v5 = connect.version is ProtocolVersion.V5
    keep_alive, limit = connect.keep_alive, state.keep_alive
    imposed = is_v5 and limit is not None and (keep_alive == 0 or keep_alive > limit)
    if imposed and limit is not None:
        keep_alive = limit
    return ConnectRequest(
        client_id=connect.client_id or f"auto-{state.random.getrandbits(128):032x}",
        assigned=not connect.client_id,
        expiry=_expiry_of(connect),
        keep_alive=keep_alive,
        keep_alive_imposed=imposed,
        receive_maximum=properties.receive_maximum or _DEFAULT_RECEIVE_MAXIMUM,
        max_packet_size=properties.maximum_packet_size or MAX_PACKET_SIZE,
        alias_maximum=min(properties.topic_alias_maximum or 0, state.limits.topic_alias_maximum),
        problem_information=properties.request_problem_information != 0,
    )


def _expiry_of(connect: Connect) -> float:
    """Return the seconds for which the session outlives its connection."""
    if connect.version is ProtocolVersion.V5:
        return expiry_of(connect.properties.session_expiry_interval or 0)
    return 0.0 if connect.clean_start else inf


def connack(login: ConnectRequest, state: BrokerState, *, session_present: bool) -> Connack:
    """Return the CONNACK for an accepted client."""
    limits = state.limits
    return Connack(
        session_present,
        ReasonCode.SUCCESS,
        Properties(
            receive_maximum=limits.receive_maximum,
            maximum_packet_size=limits.max_packet_size,
            topic_alias_maximum=limits.topic_alias_maximum,
            assigned_client_identifier=login.client_id if login.assigned else None,
            server_keep_alive=login.keep_alive if login.keep_alive_imposed else None,
        ),
    )


def expiry_of(seconds: int) -> float:
    """Return a session expiry interval as seconds: 0xFFFFFFFF is infinite."""
    return inf if seconds == _NEVER else float(seconds)


def _is_client_id(connect: Connect, state: BrokerState) -> bool:
    if not connect.client_id:
        kept = not connect.clean_start and connect.version is ProtocolVersion.V311
        return not kept and connect.version is not ProtocolVersion.V31
    return len(connect.client_id) <= state.limits.max_client_id


def _has_room(connect: Connect, state: BrokerState) -> bool:
    if len(state.peers) >= state.limits.max_connections and connect.client_id not in state.peers:
        return False
    will = will_size(connect.will)
    return will <= _SMALL_WILL or state.will_bytes + will <= state.limits.max_will_bytes


def _applicant(connect: Connect, state: BrokerState, address: str) -> Applicant | None:
    """Return the name and address that present a password, if the broker asks for one."""
    if connect.username is None or not state.authentication.required:
        return None
    return Applicant(host_of(address), connect.username, connect.client_id)


def _can_be_welcomed(connect: Connect, state: BrokerState) -> bool:
    """Return whether the client accepts packets of the size of its CONNACK, which tells it our limits."""
    limit = connect.properties.maximum_packet_size
    if limit is None:
        return True
    answer = connack(accept(connect, state), state, session_present=False)
    return len(encode(answer, connect.version)) <= limit
