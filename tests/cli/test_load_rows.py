"""Rows of ``homebot top`` from two answers."""

from homebot.cli.commands.top import Load, samples


def answer(at: float, published: dict[str, int], queues: list[dict[str, object]] | None = None) -> dict[str, object]:
    topics = [{"topic": topic, "published": count} for topic, count in published.items()]
    return {"at": at, "lag": 0.02, "topics": topics, "queues": queues or []}


def queue(node: str, waiting: int, lost: int, slowest: float) -> dict[str, object]:
    return {"node": node, "topic": "/a", "waiting": waiting, "lost": lost, "slowest": slowest}


def test_a_topic_has_its_rate_its_fullest_queue_all_losses_and_its_slowest_handler() -> None:
    queues = [queue("/quick", 7, 1, 0.001), queue("/slow", 2, 2, 0.25)]
    load = Load.between(answer(10.0, {"/a": 100}), answer(10.5, {"/a": 110, "/new": 3}, queues))
    assert [one.topic for one in load.rows] == ["/a", "/new"]
    assert [cell.strip() for cell in load.rows[0].cells()] == ["/a", "20.0", "7", "3", "250.0 ms", "slow"]
    assert load.rows[1].rate == 0.0  # since when is not known
    assert load.title == "20.0 messages/s, 7 waiting, 3 lost; loop lag 20.0 ms"


def test_a_topic_whose_publisher_left_has_no_negative_rate() -> None:
    assert Load.between(answer(0.0, {"/a": 9}), answer(1.0, {"/a": 2})).rows[0].rate == 0.0


def test_lines_stay_where_they_were_and_new_ones_come_last() -> None:
    load = Load.between(answer(0.0, {"/a": 0, "/b": 0}), answer(1.0, {"/a": 9, "/b": 1, "/c": 0}))
    assert [one.topic for one in load.in_order_of(["/b", "/a"])] == ["/b", "/a", "/c"]


def test_each_sample_is_the_load_since_the_one_before() -> None:
    answers = iter([answer(0.0, {"/a": 0}), answer(1.0, {"/a": 5}), answer(3.0, {"/a": 7})])
    found = samples(lambda: next(answers), lambda: None)
    assert [next(found).rows[0].rate, next(found).rows[0].rate] == [5.0, 1.0]
