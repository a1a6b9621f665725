"""Services are followed for as long as they say they are there, and a flood of them stays bounded; in virtual time."""

import asyncio
from collections.abc import AsyncIterator, Callable, Collection
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace

import anyio
import pytest

from homebot.clock import LoopClock
from homebot.gateways.drivers import FoundService
from homebot.gateways.mdns.network import ResolvedService, ServiceNetwork, ServiceNews
from homebot.gateways.mdns.services import (
    ANSWER_WITHIN,
    BURST,
    CHANGE_EVERY,
    CHANGES_AT_ONCE,
    GRACE,
    KEPT_AGAIN,
    MAX_WAITING,
    MAX_WAITING_OF_ALL,
    PER_SECOND,
    Services,
)

LAMP = "_lamp._tcp.local."
OTHER = "_other._tcp.local."


@dataclass
class Record:
    """What a service said, and until when that holds."""

    found: ResolvedService
    until: float


@dataclass
class FakeNetwork(ServiceNetwork):
    """A network without packets: those who answer, and what is kept of what they said."""

    answers: dict[str, ResolvedService] = field(default_factory=dict)
    kept: dict[str, Record] = field(default_factory=dict)
    there: list[ServiceNews] = field(default_factory=list)
    tell: Callable[[ServiceNews], None] = print
    asked: list[tuple[float, str]] = field(default_factory=list)
    asked_again: int = 0
    at_once: int = 0
    most_at_once: int = 0

    def say(self, found: ResolvedService) -> ServiceNews:
        """A service announces itself, all of it."""
        key = found.service.key
        self.answers[key] = found
        self.kept[key] = Record(found, asyncio.get_running_loop().time() + found.ttl)
        return ServiceNews("seen", found.service.service_type, key)

    def resolve_cached(self, service_type: str, name: str) -> ResolvedService | None:
        del service_type
        record = self.kept.get(name)
        left = 0.0 if record is None else record.until - asyncio.get_running_loop().time()
        return replace(record.found, left=left) if record is not None and left > 0 else None

    async def resolve(self, service_type: str, name: str, within: float) -> ResolvedService | None:
        del service_type
        self.asked.append((asyncio.get_running_loop().time(), name))
        self.at_once += 1
        self.most_at_once = max(self.most_at_once, self.at_once)
        await anyio.sleep(0.01 if name in self.answers else within)
        self.at_once -= 1
        if name in self.answers:
            self.say(self.answers[name])
        return self.answers.get(name)

    def forget(self, service_type: str, name: str) -> None:
        del service_type
        self.kept.pop(name, None)

    async def ask_again(self, service_types: Collection[str] | None = None) -> None:
        self.asked_again += service_types is None
        for news in self.there:
            if service_types is None or news.service_type in service_types:
                self.tell(news)


@dataclass
class RecordingHandler:
    """What is known of services."""

    there: dict[str, ResolvedService] = field(default_factory=dict)
    taken: list[str] = field(default_factory=list)
    gone: list[tuple[float, str, str]] = field(default_factory=list)
    refused: list[tuple[str, str]] = field(default_factory=list)
    delayed: list[str] = field(default_factory=list)
    connected: set[str] = field(default_factory=set)

    def publish(self, found: ResolvedService) -> None:
        self.taken.append(found.service.key)
        self.there[found.service.key] = found

    def confirm_connected(self, name: str) -> bool:
        return name in self.connected

    def drop(self, name: str, why: str) -> None:
        if self.there.pop(name, None) is not None:
            self.gone.append((asyncio.get_running_loop().time(), name, why))

    def refuse(self, name: str, why: str) -> None:
        self.refused.append((name, why))

    def delay(self, name: str) -> None:
        self.delayed.append(name)


def service(name: str, service_type: str = LAMP, ttl: float = 120.0) -> ResolvedService:
    key = f"{name}.{service_type}"
    return ResolvedService(FoundService(key, name, service_type, "hall.local.", 80, ("10.0.0.7",)), ttl, ttl)


@asynccontextmanager
async def following(
    network: FakeNetwork, most: int = 1000, *before: FoundService
) -> AsyncIterator[tuple[Services, RecordingHandler]]:
    known = RecordingHandler()
    services = Services(known, LoopClock(), most)
    network.tell = services.on_news
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(services.follow, network, before)
        await anyio.wait_all_tasks_blocked()
        yield services, known
        tasks.cancel_scope.cancel()


pytestmark = pytest.mark.virtual_time


async def test_a_dead_service_is_gone_when_its_record_has_run_out_and_it_did_not_answer() -> None:
    network = FakeNetwork()
    async with following(network) as (services, known):
        begun = asyncio.get_running_loop().time()
        services.on_news(network.say(service("Hall", ttl=120)))
        await anyio.wait_all_tasks_blocked()
        network.answers.clear()
        await anyio.sleep(200)
        ((at, name, why),) = known.gone
        assert (name, why) == (f"Hall.{LAMP}", "its announcement has run out, and it does not answer")
        assert at - begun == pytest.approx(120 + GRACE + ANSWER_WITHIN, abs=0.1)


async def test_a_service_that_does_not_answer_stays_as_long_as_its_device_is_connected() -> None:
    network = FakeNetwork()
    async with following(network) as (services, known):
        hall = network.say(service("Hall", ttl=120))
        services.on_news(hall)
        await anyio.wait_all_tasks_blocked()
        network.answers.clear()
        known.connected.add(hall.name)
        await anyio.sleep(1200)
        assert known.gone == []
        assert len(network.asked) == pytest.approx(1080 / (KEPT_AGAIN + ANSWER_WITHIN), abs=1)
        known.connected.clear()
        await anyio.sleep(KEPT_AGAIN + 2 * ANSWER_WITHIN)
        assert [name for _, name, _ in known.gone] == [hall.name]


async def test_a_living_service_is_asked_once_for_each_time_to_live_and_stays() -> None:
    network = FakeNetwork()
    async with following(network) as (services, known):
        services.on_news(network.say(service("Hall", ttl=120)))
        await anyio.sleep(3600)
        assert known.gone == []
        assert len(network.asked) == 29
        assert len(known.taken) == 30


async def test_a_service_that_comes_back_after_its_end_is_taken_in_again() -> None:
    network = FakeNetwork()
    async with following(network) as (services, known):
        services.on_news(network.say(service("Hall", ttl=10)))
        await anyio.wait_all_tasks_blocked()
        network.answers.clear()
        await anyio.sleep(20)
        assert known.there == {}
        services.on_news(network.say(service("Hall", ttl=10)))
        await anyio.wait_all_tasks_blocked()
        assert list(known.there) == [f"Hall.{LAMP}"]


async def test_a_goodbye_ends_it_at_once() -> None:
    network = FakeNetwork()
    async with following(network) as (services, known):
        services.on_news(network.say(service("Hall")))
        await anyio.wait_all_tasks_blocked()
        services.on_news(ServiceNews("gone", LAMP, f"Hall.{LAMP}"))
        assert [(name, why) for _, name, why in known.gone] == [(f"Hall.{LAMP}", "it said goodbye")]
        await anyio.sleep(300)
        assert network.asked == []


async def test_records_that_change_all_the_time_are_taken_in_now_and_then_and_the_last_ones_are() -> None:
    network = FakeNetwork()
    async with following(network) as (services, handler):
        for number in range(4 * 120):
            one = service("a")
            services.on_news(network.say(replace(one, service=replace(one.service, port=number + 1))))
            await anyio.sleep(0.25)
        assert len(handler.taken) <= CHANGES_AT_ONCE + 120 / CHANGE_EVERY + 1
        assert len(handler.delayed) >= 120 / CHANGE_EVERY - 1
        await anyio.sleep(CHANGE_EVERY + 1)
        assert handler.there[service("a").service.key].service.port == 480
        await anyio.sleep(10 * CHANGE_EVERY)
        services.on_news(network.say(service("a")))
        await anyio.sleep(1)
        assert handler.there[service("a").service.key].service.port == 80, "one that was quiet is read at once again"


async def test_one_that_comes_and_goes_all_the_time_is_taken_in_now_and_then() -> None:
    network = FakeNetwork()
    async with following(network) as (services, handler):
        for _ in range(4 * 120):
            news = network.say(service("a"))
            services.on_news(news)
            await anyio.sleep(0.125)
            services.on_news(ServiceNews("gone", news.service_type, news.name))
            await anyio.sleep(0.125)
        assert len(handler.taken) <= CHANGES_AT_ONCE + 120 / CHANGE_EVERY + 1
        assert handler.delayed
        services.on_news(network.say(service("a")))
        await anyio.sleep(2 * CHANGE_EVERY)
        assert handler.there.keys() == {service("a").service.key}


async def test_one_that_never_answers_is_counted_and_asked_once() -> None:
    network = FakeNetwork()
    async with following(network) as (services, known):
        services.on_news(ServiceNews("seen", LAMP, f"Ghost.{LAMP}"))
        await anyio.sleep(600)
        assert len(network.asked) == 1
        assert known.refused == [(f"Ghost.{LAMP}", "it is announced, and does not answer")]


async def test_a_service_with_a_short_time_to_live_is_not_asked_all_the_time() -> None:
    network = FakeNetwork()
    async with following(network) as (services, _):
        services.on_news(network.say(service("Hall", ttl=0.1)))
        await anyio.sleep(60)
        assert len(network.asked) <= 12


async def test_those_known_from_before_are_asked_several_times_before_they_are_dropped() -> None:
    network = FakeNetwork()
    hall = service("Hall").service
    async with following(network, 1000, hall) as (_, known):
        known.there[hall.key] = service("Hall")
        await anyio.sleep(3 * ANSWER_WITHIN)
        assert known.gone == []
        await anyio.sleep(10 * ANSWER_WITHIN)
        assert [name for _, name, _ in known.gone] == [hall.key]
        assert len(network.asked) == 5


class TestFlood:
    """Ten thousand services are announced at once."""

    async def test_at_most_as_many_are_followed_as_may_be_and_of_one_type_half_of_them(self) -> None:
        network = FakeNetwork()
        async with following(network, 100) as (services, known):
            for number in range(10_000):
                services.on_news(network.say(service(f"fake {number}")))
            await anyio.sleep(30)
            assert len(known.there) == 50
            assert len(known.refused) >= 10_000 - MAX_WAITING

    async def test_they_are_taken_in_at_a_pace(self) -> None:
        network = FakeNetwork()
        async with following(network, 10_000) as (services, known):
            for number in range(10_000):
                news = network.say(service(f"fake {number}", ttl=4500))
                services.on_news(replace(news, sender=f"sender {number % 100}"))
            await anyio.sleep(1)
            assert len(known.there) <= BURST + 1.5 * PER_SECOND
            await anyio.sleep(10)
            assert len(known.there) == pytest.approx(BURST + 11 * PER_SECOND, abs=10)

    async def test_those_that_do_not_answer_are_asked_a_few_at_a_time(self) -> None:
        network = FakeNetwork()
        async with following(network) as (services, _):
            for number in range(10_000):
                services.on_news(ServiceNews("seen", LAMP, f"fake {number}.{LAMP}"))
            await anyio.sleep(30)
            assert network.most_at_once == 32

    @pytest.mark.parametrize("service_type", [LAMP, OTHER])
    async def test_a_real_service_of_another_sender_is_found_at_once_all_the_same(self, service_type: str) -> None:
        network = FakeNetwork()
        async with following(network) as (services, known):
            for number in range(10_000):
                services.on_news(replace(network.say(service(f"fake {number}", service_type)), sender="10.0.0.66"))
            services.on_news(replace(network.say(service("Hall")), sender="10.0.0.7"))
            await anyio.sleep(1)
            assert f"Hall.{LAMP}" in known.there

    async def test_more_senders_than_may_wait_take_no_more_places(self) -> None:
        network = FakeNetwork()
        async with following(network) as (services, known):
            for number in range(10_000):
                services.on_news(ServiceNews("seen", LAMP, f"fake {number}.{LAMP}", f"sender {number}"))
            assert len(known.refused) == 10_000 - MAX_WAITING_OF_ALL

    async def test_a_real_service_is_found_among_names_that_do_not_answer_and_has_a_place(self) -> None:
        network = FakeNetwork()
        async with following(network, 100) as (services, known):
            for number in range(10_000):
                services.on_news(ServiceNews("seen", LAMP, f"fake {number}", f"sender {number % 100}"))
            services.on_news(network.say(service("Hall")))
            await anyio.sleep(15)
            assert list(known.there) == [f"Hall.{LAMP}"]

    async def test_the_newest_service_of_a_type_is_first(self) -> None:
        network = FakeNetwork()
        async with following(network) as (services, known):
            for number in range(200):
                services.on_news(ServiceNews("seen", LAMP, f"fake {number}.{LAMP}"))
            services.on_news(network.say(service("Hall")))
            await anyio.sleep(1)
            assert list(known.there) == [f"Hall.{LAMP}"]

    async def test_a_service_that_was_there_before_stays_and_its_end_is_noticed(self) -> None:
        network = FakeNetwork()
        async with following(network) as (services, known):
            services.on_news(network.say(service("Hall", ttl=120)))
            await anyio.wait_all_tasks_blocked()
            for number in range(10_000):
                services.on_news(ServiceNews("seen", LAMP, f"fake {number}.{LAMP}"))
            await anyio.sleep(110)
            assert f"Hall.{LAMP}" in known.there
            del network.answers[f"Hall.{LAMP}"]
            await anyio.sleep(60)
            assert f"Hall.{LAMP}" not in known.there

    async def test_a_real_service_that_was_dropped_with_them_is_found_once_there_is_room(self) -> None:
        network = FakeNetwork()
        async with following(network) as (services, known):
            for number in range(1000):
                services.on_news(ServiceNews("seen", LAMP, f"fake {number}.{LAMP}"))
            hall = network.say(service("Hall", ttl=4500))
            services.on_news(hall)
            assert known.refused[-1][0] == hall.name
            network.there.append(hall)
            await anyio.sleep(120)
            assert list(known.there) == [hall.name]


async def test_all_types_are_asked_for_anew_now_and_then() -> None:
    network = FakeNetwork()
    async with following(network):
        await anyio.sleep(3601)
        assert network.asked_again == 6
