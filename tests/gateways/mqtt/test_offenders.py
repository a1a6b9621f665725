from homebot.gateways.mqtt.offenders import Offenders


def repeat(offenders: Offenders, name: str, start: float, times: int = 5) -> float | None:
    last = None
    for number in range(times):
        last = offenders.offend(name, "why", start + number)
    return None if last is None else last.until - last.since


def test_five_offences_in_ten_minutes_are_too_many() -> None:
    offenders = Offenders()
    assert repeat(offenders, "a", 0.0, times=4) is None
    assert not offenders.is_confined("a")
    assert offenders.offend("a", "last", 599.0) is not None
    assert offenders.is_confined("a")
    assert [one.why for one in offenders.confined()] == ["last"]


def test_five_offences_in_a_longer_time_are_not() -> None:
    offenders = Offenders()
    for number in range(20):
        assert offenders.offend("a", "why", number * 200.0) is None


def test_each_term_is_twice_as_long_to_a_day_at_most() -> None:
    offenders = Offenders()
    terms = [repeat(offenders, "a", number * 1e6) for number in range(12)]
    assert terms[:3] == [600.0, 1200.0, 2400.0]
    assert terms[-1] == 86_400.0


def test_who_is_released_is_listened_to_and_not_forgotten() -> None:
    offenders = Offenders()
    repeat(offenders, "a", 0.0)
    released = offenders.release("a")
    assert released is not None
    assert released.offences == 5
    assert offenders.release("a") is None
    assert offenders.confined() == ()


def test_a_flood_of_offenders_is_bounded_and_the_quietest_is_forgotten() -> None:
    offenders = Offenders(max_offenders=3)
    repeat(offenders, "first", 0.0)
    for number in range(3):
        offenders.offend(str(number), "why", 10.0)
    assert offenders.forgotten == 1
    assert not offenders.is_confined("first")
