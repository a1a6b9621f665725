from homebot.gateways.announced.last_messages import CachedMessage, LastMessageCache
from homebot.messages import Time

NOW = Time(sec=1, nanosec=0)


def word(payload: bytes) -> CachedMessage:
    return CachedMessage(payload, retained=False, at=NOW, heard_at=1.0)


def keep(words: LastMessageCache, topic: str, payload: bytes) -> None:
    words.put(topic, payload, NOW, 1.0, retained=False)


def test_the_last_word_is_kept() -> None:
    words = LastMessageCache()
    keep(words, "a", b"1")
    keep(words, "a", b"2")
    assert words.get("a") == word(b"2")


def test_the_message_replaced_the_longest_ago_goes_first() -> None:
    words = LastMessageCache(max_total=23)
    for name in "abc":
        keep(words, name, b"0123456789")
    assert [words.get(name) is None for name in "abc"] == [True, False, False]


def test_a_long_one_is_not_kept_and_neither_is_what_it_replaces() -> None:
    words = LastMessageCache(max_each=3)
    keep(words, "a", b"123")
    keep(words, "a", b"1234")
    assert words.get("a") is None


def test_a_replaced_or_too_long_message_makes_room() -> None:
    words = LastMessageCache(max_total=22, max_each=10)
    for payload in (b"0123456789", b"1", b"0123456789", b"01234567890"):
        keep(words, "a", payload)
    for name in "bc":
        keep(words, name, b"0123456789")
    assert [words.get(name) is None for name in "abc"] == [True, False, False]
