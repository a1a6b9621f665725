"""The supervisor over a client that does as it is told, in virtual time."""

from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from random import Random

import anyio
import pytest
from anyio import wait_all_tasks_blocked
from structlog.testing import capture_logs

from homebot.errors import ClosedError, InvalidNameError, LinkError, RefusedError, UsageError
from homebot.mqtt.client import MqttClient, MqttCounters, MqttSubscription, SessionGrant
from homebot.mqtt.client.link import ClientLink
from homebot.mqtt.connection import ConnectionState, LinkPhase, MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import NO_PROPERTIES, Properties
from homebot.support.backoff import Backoff

pytestmark = pytest.mark.virtual_time

FRESH = SessionGrant(resumed=False, protocol="5")
RESUMED = SessionGrant(resumed=True, protocol="5")
ABSENT = LinkError("nobody there")
WRONG_PASSWORD = RefusedError("the login", "bad user name or password", 0x86)
EXACT = Backoff(first=1.0, factor=2.0, cap=4.0, late_cap=60.0, late_after=1000.0, jitter=0.0)
SLOW = Backoff(first=100.0, factor=2.0, cap=1000.0, late_cap=1000.0, late_after=1000.0, jitter=0.0)


class FakeClient(MqttClient):
    """Each try to connect meets the next of `answers`, and the last one again and again."""

    def __init__(self, *answers: SessionGrant | LinkError | RefusedError) -> None:
        self.options: MqttOptions | None = None
        self.answers = deque(answers)
        self.tries: list[float] = []
        self.said: list[str] = []
        self.published: list[tuple[int, Properties]] = []
        self.refused_filters: set[str] = set()
        self.refuses_publish = False
        self.unanswered = 0
        self.burst = 0
        self.brings: dict[str, int] = {}
        self.requests: list[int] = []
        self.may_subscribe = anyio.Event()
        self.may_subscribe.set()
        self.acked: list[MqttMessage] = []
        self.counters = MqttCounters()
        self.inbox: list[MqttMessage] = []
        self._up = False
        self.receive, self.ack = self._receive, self.acked.extend
        self._gone = anyio.Event()
        self._news = anyio.Event()
        self._reason: LinkError | RefusedError = ABSENT

    def __call__(self, options: MqttOptions) -> MqttClient:
        self.options = options
        return self

    @asynccontextmanager
    async def connected(self) -> AsyncIterator[SessionGrant]:
        self.tries.append(round(anyio.current_time(), 6))
        answer = self.answers.popleft() if len(self.answers) > 1 else self.answers[0]
        if not isinstance(answer, SessionGrant):
            raise answer
        self._up, self._gone = True, anyio.Event()
        try:
            yield answer
        finally:
            self._up = False
            self.tell()

    async def wait_lost(self) -> LinkError | RefusedError:
        await self._gone.wait()
        return self._reason

    def drop(self) -> None:
        self._reason = LinkError("dropped")
        self._gone.set()

    async def publish(
        self,
        topic: str,
        payload: bytes = b"",
        *,
        qos: int = 0,
        retain: bool = False,
        properties: Properties = NO_PROPERTIES,
    ) -> int:
        self._check()
        if self.refuses_publish:
            raise RefusedError("the publish", "not authorized", 0x87)
        self.published.append((qos, properties))
        self.said.append(f"{topic} {payload.decode()}{' retained' if retain else ''}")
        return 0

    async def receive_burst(self) -> None:
        """A hundred messages each 10 ms, so many times."""
        for _ in range(self.burst):
            self.counters.received += 100
            await anyio.sleep(0.01)

    async def subscribe(self, *subscriptions: MqttSubscription) -> tuple[int, ...]:
        self._check()
        await self.may_subscribe.wait()
        self._check()
        self.requests.append(len(subscriptions))
        self.counters.retained += sum(self.brings.get(subscription.filter, 0) for subscription in subscriptions)
        if self.burst:
            await anyio.sleep(0.001)
        if self.unanswered:
            self.unanswered -= 1
            raise LinkError("no answer to subscribe within 10 s")
        for subscription in subscriptions:
            if subscription.filter in self.refused_filters:
                raise RefusedError(f"the subscription to {subscription.filter!r}", "not authorized", 0x87)
            self.said.append(f"subscribe {subscription.filter}")
        return tuple(subscription.qos for subscription in subscriptions)

    async def unsubscribe(self, *filters: str) -> None:
        self._check()
        self.said.extend(f"unsubscribe {name}" for name in filters)

    async def _open(self, *_: object) -> ClientLink:
        raise NotImplementedError

    async def _receive(self) -> list[MqttMessage]:
        while not self.inbox:
            self._check()
            await self._news.wait()
        batch, self.inbox = self.inbox, []
        return batch

    def lose(self, reason: LinkError | RefusedError = ABSENT) -> None:
        self._reason = reason
        self._up = False
        self._gone.set()
        self.tell()

    def tell(self, *messages: MqttMessage) -> None:
        self.inbox.extend(messages)
        self._news.set()
        self._news = anyio.Event()

    def _check(self) -> None:
        if not self._up:
            raise ABSENT


def supervise(client: FakeClient, *, status_topic: str | None = None, is_paced: bool = True) -> MqttConnection:
    return MqttConnection(
        MqttOptions(host="broker", client_id="hub"),
        client,
        status_topic=status_topic,
        random=Random(1),  # noqa: S311 - jitter is no secret
        link_backoff=EXACT,
        refused_backoff=SLOW,
        is_paced=is_paced,
    )


async def until(connection: MqttConnection, phase: LinkPhase) -> ConnectionState:
    async for state in connection.states():
        if state.phase is phase:
            return state
    pytest.fail(f"closed before {phase}")


async def test_entering_does_not_wait_for_a_broker_that_is_absent() -> None:
    async with supervise(FakeClient(ABSENT)) as connection:
        state = await until(connection, LinkPhase.WAITING)
        assert state == ConnectionState(LinkPhase.WAITING, "nobody there", 1.0)


async def test_an_absent_broker_is_tried_again_with_growing_delays() -> None:
    client = FakeClient(ABSENT, ABSENT, ABSENT, ABSENT, ABSENT, FRESH)
    async with supervise(client) as connection:
        await until(connection, LinkPhase.CONNECTED)
    start = client.tries[0]
    assert [moment - start for moment in client.tries] == [0, 1, 3, 7, 11, 15]


async def test_a_link_that_breaks_after_a_while_is_made_again_at_once() -> None:
    client = FakeClient(FRESH)
    async with supervise(client) as connection:
        await until(connection, LinkPhase.CONNECTED)
        await anyio.sleep(60)
        client.lose()
        await wait_all_tasks_blocked()
        await connection.wait_connected()
    assert client.tries[1] - client.tries[0] == 60


async def test_a_link_that_breaks_right_after_the_login_is_not_made_in_a_hot_loop() -> None:
    client = FakeClient(FRESH)
    async with supervise(client) as connection:
        for _ in range(4):
            await connection.wait_connected()
            client.lose()
            await wait_all_tasks_blocked()
            await until(connection, LinkPhase.CONNECTED)
    delays = [after - before for before, after in zip(client.tries, client.tries[1:], strict=False)]
    assert delays == [0, 2, 4, 4]


async def test_a_refused_login_is_a_state_of_its_own_and_repeated_slowly() -> None:
    client = FakeClient(WRONG_PASSWORD, WRONG_PASSWORD, FRESH)
    async with supervise(client) as connection:
        state = await until(connection, LinkPhase.REFUSED)
        assert "bad user name or password" in state.reason
        assert state.retry_in == 100
        with pytest.raises(RefusedError, match="bad user name or password"):
            await connection.wait_connected()
        await until(connection, LinkPhase.CONNECTED)
    assert client.tries[-1] - client.tries[0] == 300


async def test_who_is_thrown_out_comes_back_slowly() -> None:
    """Two programs with one client id would push each other out for ever."""
    client = FakeClient(FRESH)
    async with supervise(client) as connection:
        await until(connection, LinkPhase.CONNECTED)
        await anyio.sleep(60)
        client.lose(RefusedError("the connection", "session taken over", 0x8E))
        assert (await until(connection, LinkPhase.REFUSED)).retry_in == 100


async def test_a_certificate_file_that_cannot_be_used_waits_for_a_person() -> None:
    class Unusable(FakeClient):
        @asynccontextmanager
        async def connected(self) -> AsyncIterator[SessionGrant]:
            if not self.tries:
                self.tries.append(0)
                raise UsageError("CA file ca.pem: No such file or directory")
            async with super().connected() as session:
                yield session

    async with supervise(Unusable(FRESH)) as connection:
        assert "ca.pem" in (await until(connection, LinkPhase.REFUSED)).reason
        await until(connection, LinkPhase.CONNECTED)


async def test_subscriptions_are_made_again_on_a_new_session() -> None:
    client = FakeClient(FRESH)
    async with supervise(client) as connection:
        await connection.subscribe(MqttSubscription("early"))
        await connection.wait_connected()
        await connection.subscribe(MqttSubscription("late"))
        client.lose()
        await wait_all_tasks_blocked()
        await connection.wait_connected()
    assert client.said == ["subscribe early", "subscribe late", "subscribe early", "subscribe late"]


async def test_a_resumed_session_keeps_its_subscriptions_and_gets_only_the_changes() -> None:
    client = FakeClient(FRESH, ABSENT, RESUMED)
    async with supervise(client) as connection:
        await connection.wait_connected()
        await connection.subscribe(MqttSubscription("kept"), MqttSubscription("dropped"))
        client.lose()
        await until(connection, LinkPhase.WAITING)
        await connection.subscribe(MqttSubscription("new"))
        await connection.unsubscribe("dropped")
        await until(connection, LinkPhase.CONNECTED)
    assert client.said == ["subscribe kept", "subscribe dropped", "subscribe new", "unsubscribe dropped"]


async def test_what_is_wanted_on_every_link_is_subscribed_to_again_also_in_a_resumed_session() -> None:
    """Messages of QoS 0 are not kept for who is away; what the broker keeps comes with the new subscription."""
    client = FakeClient(FRESH, RESUMED)
    async with supervise(client) as connection:
        await connection.wait_connected()
        await connection.subscribe(MqttSubscription("again/#"), every_link=True)
        await connection.subscribe(MqttSubscription("kept"), MqttSubscription("once"))
        await connection.subscribe(MqttSubscription("once"), every_link=True)
        await connection.subscribe(MqttSubscription("once"))
        client.said.clear()
        client.lose()
        await wait_all_tasks_blocked()
        await connection.wait_connected()
    assert client.said == ["subscribe again/#"]


async def test_an_unanswered_subscription_is_asked_for_once_more() -> None:
    """A broker that sends all that it keeps may drop its answer."""
    client = FakeClient(FRESH)
    client.unanswered = 1
    async with supervise(client) as connection:
        await connection.subscribe(MqttSubscription("a"))
        await connection.wait_connected()
    assert (client.said, len(client.tries)) == (["subscribe a"], 1)


async def test_the_next_subscription_waits_until_a_burst_has_passed() -> None:
    client = FakeClient(FRESH)
    async with supervise(client) as connection, anyio.create_task_group() as tasks:
        await connection.wait_connected()
        client.burst = 5
        tasks.start_soon(client.receive_burst)
        await connection.subscribe(MqttSubscription("a/#"), MqttSubscription("b/#"))
        assert anyio.current_time() >= 0.05
        assert client.counters.received == 500


async def test_a_broker_that_never_falls_silent_is_waited_for_once_only() -> None:
    client = FakeClient(FRESH)
    async with supervise(client) as connection, anyio.create_task_group() as tasks:
        await connection.wait_connected()
        client.burst = 1000
        tasks.start_soon(client.receive_burst)
        await connection.subscribe(*(MqttSubscription(f"{number}/#") for number in range(50)))
        assert 1.0 <= anyio.current_time() < 1.2
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize("session", [FRESH, RESUMED])
async def test_a_message_is_received_and_acknowledged_before_all_subscriptions_are_made_again(
    session: SessionGrant,
) -> None:
    client, pressed = FakeClient(FRESH, session), MqttMessage("button", b"1", 1)

    async def read(connection: MqttConnection) -> None:
        while True:
            connection.ack(await connection.receive())

    async with supervise(client) as connection, anyio.create_task_group() as tasks:
        await connection.wait_connected()
        await connection.subscribe(MqttSubscription("#"), every_link=True)
        tasks.start_soon(read, connection)
        client.may_subscribe = anyio.Event()
        client.lose()
        await until(connection, LinkPhase.SUBSCRIBING)
        client.tell(pressed)
        await wait_all_tasks_blocked()
        assert client.acked == [pressed]
        tasks.cancel_scope.cancel()


async def test_a_command_may_be_sent_into_a_resumed_session_before_its_subscriptions_are_made_again() -> None:
    client = FakeClient(FRESH, RESUMED)
    async with supervise(client) as connection:
        await connection.wait_connected()
        await connection.subscribe(MqttSubscription("#"), every_link=True)
        client.may_subscribe = anyio.Event()
        client.lose()
        await until(connection, LinkPhase.SUBSCRIBING)
        await connection.require_link()
        assert connection.state.phase is LinkPhase.SUBSCRIBING


async def test_a_command_waits_for_the_subscriptions_of_a_new_session_and_fails_with_its_link() -> None:
    """Its answer would be lost."""
    client, sent = FakeClient(FRESH), list[str]()

    async def send(connection: MqttConnection) -> None:
        try:
            await connection.require_link()
        except LinkError:
            sent.append("no link")
        else:
            sent.append("sent")

    async with supervise(client) as connection, anyio.create_task_group() as tasks:
        await connection.subscribe(MqttSubscription("#"))
        client.may_subscribe = anyio.Event()
        await until(connection, LinkPhase.SUBSCRIBING)
        tasks.start_soon(send, connection)
        await wait_all_tasks_blocked()
        assert sent == []
        client.may_subscribe.set()
        await connection.wait_connected()
        await wait_all_tasks_blocked()
        assert sent == ["sent"]
        client.may_subscribe = anyio.Event()
        client.lose()
        await until(connection, LinkPhase.SUBSCRIBING)
        tasks.start_soon(send, connection)
        await wait_all_tasks_blocked()
        client.lose()
        client.may_subscribe.set()
        await until(connection, LinkPhase.WAITING)
        await wait_all_tasks_blocked()
        assert sent == ["sent", "no link"]


async def test_filters_that_brought_nothing_are_requested_together_on_the_next_link() -> None:
    """What announces all devices of a house comes alone."""
    client = FakeClient(FRESH)
    client.brings = {"7/#": 60, "8/#": 60, "9/#": 2_000}
    async with supervise(client) as connection:
        await connection.subscribe(*(MqttSubscription(f"{number}/#") for number in range(99)))
        await connection.wait_connected()
        assert client.requests == [1] * 99
        client.requests.clear()
        client.lose()
        await wait_all_tasks_blocked()
        await connection.wait_connected()
        assert client.requests == [96, 1, 1, 1]


@pytest.mark.parametrize(("is_paced", "requests"), [(True, [3, 1, 1, 1]), (False, [6])])
async def test_plain_topics_are_requested_together_and_all_where_the_broker_drops_nothing(
    is_paced: bool,  # noqa: FBT001
    requests: list[int],
) -> None:
    client = FakeClient(FRESH)
    async with supervise(client, is_paced=is_paced) as connection:
        wanted = [*map(MqttSubscription, ("a", "c/+", "b", "#", "d")), MqttSubscription("e", qos=1)]
        await connection.subscribe(*wanted)
        await connection.wait_connected()
    assert client.requests == requests


async def test_filters_that_bring_more_than_they_did_are_requested_alone_again() -> None:
    client = FakeClient(FRESH)
    async with supervise(client) as connection:
        await connection.subscribe(MqttSubscription("a/#"), MqttSubscription("b/#"))
        for requests in ([1, 1], [2], [1, 1], [1, 1]):
            await connection.wait_connected()
            assert client.requests == requests
            client.requests.clear()
            client.brings = {"a/#": 2_000}
            client.lose()
            await wait_all_tasks_blocked()


async def test_a_refused_topic_costs_those_requested_along_with_it_one_link_only() -> None:
    client = FakeClient(FRESH)
    client.refused_filters = {"secret"}
    async with supervise(client) as connection:
        await connection.subscribe(*map(MqttSubscription, ("a", "secret", "b")))
        await connection.wait_connected()
        assert client.requests == [3, 1, 1, 1]
        client.requests.clear()
        client.lose()
        await wait_all_tasks_blocked()
        await connection.wait_connected()
        assert client.requests == [2, 1]


async def test_the_first_link_of_a_process_subscribes_even_into_an_old_session() -> None:
    client = FakeClient(RESUMED)
    async with supervise(client) as connection:
        await connection.subscribe(MqttSubscription("a"))
        await connection.wait_connected()
    assert client.said == ["subscribe a"]


async def test_a_refused_subscription_is_raised_and_the_others_stand() -> None:
    client = FakeClient(FRESH)
    client.refused_filters = {"secret/#"}
    async with supervise(client) as connection:
        await connection.wait_connected()
        with pytest.raises(RefusedError, match="'secret/#' was refused: not authorized"):
            await connection.subscribe(MqttSubscription("secret/#"), MqttSubscription("open/#"))
        assert connection.refused == {"secret/#": "not authorized"}
        client.lose()
        await wait_all_tasks_blocked()
        await connection.wait_connected()
    assert client.said == ["subscribe open/#"] * 2


async def test_refused_subscriptions_of_a_new_link_are_there_to_be_read_in_one_quiet_line() -> None:
    client = FakeClient(FRESH)
    client.refused_filters = {"a", "b"}
    with capture_logs() as lines:
        async with supervise(client) as connection:
            await connection.subscribe(MqttSubscription("a"), MqttSubscription("b"), MqttSubscription("c"))
            await connection.wait_connected()
            assert connection.refused == {"a": "not authorized", "b": "not authorized"}
    (line,) = [line for line in lines if line["event"] == "mqtt.subscriptions_refused"]
    assert (line["log_level"], line["filters"]) == ("debug", ["a", "b"])
    assert client.said == ["subscribe c"]


@pytest.mark.parametrize("session", [FRESH, RESUMED])
async def test_a_refused_subscription_is_asked_for_again_on_the_next_link(session: SessionGrant) -> None:
    client = FakeClient(FRESH, ABSENT, session)
    client.refused_filters = {"early", "late"}
    async with supervise(client) as connection:
        await connection.subscribe(MqttSubscription("early"))
        await connection.wait_connected()
        with pytest.raises(RefusedError):
            await connection.subscribe(MqttSubscription("late"))
        client.refused_filters.clear()
        client.lose()
        await until(connection, LinkPhase.WAITING)
        assert connection.refused == {}
        await connection.wait_connected()
        assert connection.refused == {}
    assert client.said == ["subscribe early", "subscribe late"]


async def test_who_gives_a_refused_subscription_up_hears_no_more_of_it() -> None:
    client = FakeClient(FRESH)
    client.refused_filters = {"a"}
    async with supervise(client) as connection:
        await connection.subscribe(MqttSubscription("a"))
        await connection.wait_connected()
        await connection.unsubscribe("a")
        assert connection.refused == {}


async def test_a_filter_that_is_none_is_refused_even_while_the_link_is_down() -> None:
    async with supervise(FakeClient(ABSENT)) as connection:
        with pytest.raises(InvalidNameError):
            await connection.subscribe(MqttSubscription("a/#/b"))


async def test_a_publish_while_the_link_is_down_fails_at_once() -> None:
    async with supervise(FakeClient(ABSENT)) as connection:
        with pytest.raises(LinkError):
            await connection.publish("t", b"x", qos=1)


async def test_one_reader_gets_the_messages_of_all_links() -> None:
    client = FakeClient(FRESH, ABSENT, FRESH)
    first, second = MqttMessage("t", b"1", 1), MqttMessage("t", b"2", 1)
    got: list[MqttMessage] = []

    async def read(connection: MqttConnection) -> None:
        for _ in range(2):
            batch = await connection.receive()
            got.extend(batch)
            connection.ack(batch)
        with pytest.raises(ClosedError):
            await connection.receive()

    async with anyio.create_task_group() as tasks, supervise(client) as connection:
        tasks.start_soon(read, connection)
        await connection.wait_connected()
        client.tell(first)
        await wait_all_tasks_blocked()
        client.lose()
        await until(connection, LinkPhase.WAITING)
        await connection.wait_connected()
        client.tell(second)
        await wait_all_tasks_blocked()
    assert got == client.acked == [first, second]


async def test_a_reader_of_a_connection_that_never_came_up_is_freed_by_closing() -> None:
    async def read(connection: MqttConnection) -> None:
        with pytest.raises(ClosedError):
            await connection.receive()

    async with anyio.create_task_group() as tasks, supervise(FakeClient(ABSENT)) as connection:
        tasks.start_soon(read, connection)
        await wait_all_tasks_blocked()


async def test_online_and_offline_are_announced_and_the_will_says_it_for_a_crash() -> None:
    client = FakeClient(FRESH)
    async with supervise(client, status_topic="") as connection:
        assert connection.status_topic == "homebot/hub/status"
        await connection.wait_connected()
    assert client.said == ["homebot/hub/status online retained", "homebot/hub/status offline retained"]
    assert client.published == [(1, NO_PROPERTIES)] * 2
    assert client.options is not None
    will = client.options.will
    assert will is not None
    assert (will.topic, will.payload, will.retain) == ("homebot/hub/status", b"offline", True)


async def test_a_broker_that_refuses_the_announcement_is_used_all_the_same() -> None:
    client = FakeClient(FRESH)
    client.refuses_publish = True
    with capture_logs() as lines:
        async with supervise(client, status_topic="status") as connection:
            await connection.wait_connected()
    assert {line["event"] for line in lines} >= {"mqtt.status_refused"}


async def test_states_are_told_until_closed() -> None:
    seen: list[LinkPhase] = []

    async def watch(connection: MqttConnection) -> None:
        seen.extend([state.phase async for state in connection.states()])

    async with anyio.create_task_group() as tasks, supervise(FakeClient(ABSENT, FRESH)) as connection:
        tasks.start_soon(watch, connection)
        await connection.wait_connected()
        await wait_all_tasks_blocked()
    assert seen[-3:] == [LinkPhase.WAITING, LinkPhase.CONNECTED, LinkPhase.CLOSED]
    with pytest.raises(ClosedError):
        await connection.wait_connected()


async def test_an_error_inside_the_block_comes_out_as_it_is() -> None:
    with pytest.raises(ValueError, match="mine"):
        async with supervise(FakeClient(FRESH)):
            raise ValueError("mine")


async def test_a_connection_can_be_opened_again_but_not_twice_at_once() -> None:
    connection = supervise(FakeClient(FRESH))
    for _ in range(2):
        async with connection:
            await connection.wait_connected()
            with pytest.raises(UsageError, match="already open"):
                await connection.__aenter__()
