"""Who knows the setup code proves it: aiohomekit's side of SRP against ours."""

import pytest

from homebot.features.homekit_bridge.setup_code import SetupCodeCheck

srp = pytest.importorskip("aiohomekit.crypto.srp")

CODE = "031-45-154"


def controller(check: SetupCodeCheck, code: str) -> object:
    client = srp.SrpClient("Pair-Setup", code)
    salt, public = check.get_challenge()
    client.set_salt(int.from_bytes(salt))
    client.set_server_public_key(public.to_bytes(384))
    check.set_A(bytes(client.get_public_key_bytes()))
    return client


def test_who_knows_the_code_has_the_key_of_the_session_at_every_try() -> None:
    """A number in a hundred begins with a zero, and all count with it."""
    for _ in range(150):
        check = SetupCodeCheck(CODE.encode())
        client: object = controller(check, CODE)
        answer = check.verify(client.get_proof_bytes())  # type: ignore[attr-defined]
        assert answer is not None
        assert client.verify_servers_proof_bytes(answer)  # type: ignore[attr-defined]
        assert check.get_session_key() == client.get_session_key()  # type: ignore[attr-defined]


def test_who_does_not_know_the_code_gets_no_proof_and_no_key() -> None:
    check = SetupCodeCheck(CODE.encode())
    client: object = controller(check, "111-22-333")
    assert check.verify(client.get_proof_bytes()) is None  # type: ignore[attr-defined]
    assert check.get_session_key() != check.get_session_key()


@pytest.mark.parametrize("public", [bytes(384), b"\1" * 385, b""])
def test_a_public_key_by_which_all_would_know_the_session_is_refused(public: bytes) -> None:
    check = SetupCodeCheck(CODE.encode())
    with pytest.raises(ValueError, match="no public key"):
        check.set_A(public)
    assert check.is_used
    assert check.verify(b"") is None
