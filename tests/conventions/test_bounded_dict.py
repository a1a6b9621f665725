from homebot.conventions.bounded_dict import BoundedDict


def test_a_new_one_takes_the_place_of_the_oldest_that_is_not_kept() -> None:
    forgotten: list[int] = []
    room: BoundedDict[int] = BoundedDict(2, forgotten.append)
    assert room.add("a", 1)
    assert room.add("b", 2)
    room.pin("a")
    assert room.add("c", 3)
    assert (room.get("a"), room.get("b"), room.get("c")) == (1, None, 3)
    assert forgotten == [2]
    assert room.dropped == 1


def test_a_pinned_value_is_not_dropped() -> None:
    room: BoundedDict[int] = BoundedDict(1)
    room.add("a", 1)
    room.pin("a")
    assert not room.add("b", 2)
    assert len(room) == 1
    assert room.dropped == 1


def test_a_removed_value_makes_room() -> None:
    room: BoundedDict[int] = BoundedDict(1)
    room.add("a", 1)
    room.pin("a")
    assert room.remove("a") == 1
    assert room.remove("a") is None
    assert room.add("b", 2)
    assert room.dropped == 0
