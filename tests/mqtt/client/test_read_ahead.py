from hypothesis import given
from hypothesis import strategies as st

from homebot.mqtt.client.tcp_transport import ReadAhead


@given(st.lists(st.binary(max_size=50)), st.integers(1, 20))
def test_bytes_come_out_in_order_and_in_portions(chunks: list[bytes], portion: int) -> None:
    ahead = ReadAhead(portion, 1000)
    for chunk in chunks:
        ahead.put(chunk)
    taken = []
    while ahead.size:
        taken.append(ahead.pop())
    assert b"".join(taken) == b"".join(chunks)
    assert all(len(one) <= portion for one in taken)


def test_it_is_full_until_enough_is_taken() -> None:
    ahead = ReadAhead(4, 6)
    ahead.put(b"12345")
    assert not ahead.is_full
    ahead.put(b"6")
    assert ahead.is_full
    assert ahead.pop() == b"1234"
    assert not ahead.is_full


def test_nothing_is_left_of_nothing() -> None:
    assert ReadAhead(4, 6).pop() == b""
