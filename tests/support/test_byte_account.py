"""Byte account."""

from __future__ import annotations

from homebot.support.byte_account import ByteAccount


class Client:
    def __init__(self, name: str, account: ByteAccount[Client]) -> None:
        self.name = name
        self.size = 0
        self._account = account

    def hold(self, size: int) -> None:
        self.size += size
        self._account.add(size)

    def shed(self) -> None:
        self._account.add(-self.size)
        self.size = 0


def make(names: str, most: int = 1000) -> tuple[ByteAccount[Client], list[Client]]:
    clients: list[Client] = []
    account: ByteAccount[Client] = ByteAccount(most, lambda: clients, lambda one: one.size, Client.shed)
    clients += [Client(name, account) for name in names]
    return account, clients


def test_above_the_bound_the_largest_client_sheds_first() -> None:
    account, clients = make("abcd")
    for client, size in zip(clients, (100, 400, 300, 500), strict=True):
        client.hold(size)
    assert [client.size for client in clients] == [100, 400, 300, 0]
    assert account.used == 800


def test_of_equal_clients_the_oldest_sheds() -> None:
    _, clients = make("abc")
    for client in clients:
        client.hold(400)
    assert [client.size for client in clients] == [0, 400, 400]


def test_clients_are_counted_anew_before_one_of_them_sheds() -> None:
    """A socket is emptied by the system, which does not report it."""
    current = {"quick": 900, "slow": 500}
    counted = dict(current)
    shed: list[str] = []

    def count(name: str) -> int:
        change, counted[name] = current[name] - counted[name], current[name]
        account.add(change)
        return counted[name]

    account: ByteAccount[str] = ByteAccount(1000, lambda: current, count, shed.append)
    account.add(900)
    current["quick"] = 0
    account.add(500)
    assert shed == []
    assert account.used == 500


def test_a_client_that_cannot_shed_is_passed_over() -> None:
    account, clients = make("ab")
    account.add(700)  # of nobody here
    clients[0].hold(200)
    clients[1].hold(200)
    assert [client.size for client in clients] == [0, 200]
    account.add(500)
    assert [client.size for client in clients] == [0, 0]
    assert account.used == 1200


def test_without_time_the_rest_is_for_later() -> None:
    account, clients = make("abc")
    account.on_overrun = lambda: None
    for client in clients:
        client.hold(900)
    times = iter([True, False])
    assert not account.relieve(lambda: next(times))
    assert [client.size for client in clients] == [0, 900, 900]
    assert account.relieve()
    assert [client.size for client in clients] == [0, 0, 900]


def test_a_client_that_may_lose_more_is_asked_again_before_a_smaller_one() -> None:
    sizes = {"large": 900, "small": 500}
    shed: list[str] = []

    def lose(name: str) -> bool:
        shed.append(name)
        if shed == ["large"]:
            return True
        account.add(-sizes[name])
        sizes[name] = 0
        return False

    account: ByteAccount[str] = ByteAccount(1000, lambda: sizes, sizes.__getitem__, lose)
    account.add(1400)
    assert shed == ["large", "large"]
