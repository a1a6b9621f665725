"""Services through the door, in both directions."""

import asyncio
import re
from typing import Any

import anyio
import pytest
from pydantic import SecretStr
from tests.bridges.conftest import House, Peer
from tests.patience import PATIENCE

from homebot.bridges.rosbridge import ClientToken, RosbridgeSettings
from homebot.devices.lease_messages import HoldPart, HoldRequest, LeaseState
from homebot.devices.names import HOLD_PART
from homebot.errors import RefusedError, ServiceFailedError, ServiceGoneError, ServiceTimeoutError
from homebot.messages import SetBool, Trigger
from homebot.messages.definition import zero_message
from homebot.messages.std_srvs import SetBoolRequest, SetBoolResponse, SuccessResponse, TriggerRequest


def echo(request: SetBoolRequest) -> SetBoolResponse:
    return SetBoolResponse(success=request.data, message="done")


async def test_a_client_calls_a_service(house: House, peer: Peer) -> None:
    house.node("lamp").create_service(SetBool, "/switch", echo)
    await peer.send("call_service", id="x:1", service="switch", args={"data": True})
    assert await peer.receive() == {
        "op": "service_response",
        "id": "x:1",
        "service": "switch",
        "result": True,
        "values": {"success": True, "message": "done"},
    }
    assert house.entities() == set()


async def test_a_call_of_a_service_that_is_about_to_begin_waits_for_it(house: House, peer: Peer) -> None:
    """For two seconds after a start the page told that no history is kept."""
    house.graph.coming |= {"/switch"}
    for name in ("/switch", "/nothing"):
        await peer.send("call_service", service=name, args={"data": True})
    assert "no server" in (await peer.receive())["values"]
    house.node("lamp").create_service(SetBool, "/switch", echo)
    assert (await peer.receive())["values"] == {"success": True, "message": "done"}


async def test_what_a_link_delivers_after_its_client_gave_it_up_is_not_carried_out(house: House, peer: Peer) -> None:
    """A tap during an outage opened the garage when the link was back, long after the page had told that it failed."""
    done: list[bool] = []

    def switch(request: SetBoolRequest) -> SetBoolResponse:
        done.append(request.data)
        return SetBoolResponse(success=True, message="done")

    house.node("lamp").create_service(SetBool, "/switch", switch)
    # The clock of the client is a year behind; the second call is 20 s late, and the last one not.
    for sent, data in ((1000.0, False), (980.0, True), (1000.5, False)):
        await peer.send("call_service", service="/switch", args={"data": data}, sent=sent, patience=15)
        answer = await peer.receive()
        assert answer["result"] is not data, answer
    assert done == [False, False]
    await peer.send("call_service", service="/switch", args={"data": True}, sent=900)
    assert (await peer.receive())["result"], "it waits for ever"


async def test_what_a_request_and_its_response_lack_is_zero_or_empty_but_not_of_a_type_of_homebot(
    house: House, peer: Peer
) -> None:
    """As the original bridge makes them; a command of homebot says what it means."""
    switch = house.node("lamp").create_service(SetBool, "/switch", echo)
    await peer.send("call_service", service="/switch", args={})
    assert (await peer.receive())["values"]["success"] is False
    switch.close()
    await peer.send("advertise_service", service="/switch", type="std_srvs/SetBool")
    await peer.send("call_service", service="/switch", args=[True])
    asked = await peer.receive()
    await peer.send("service_response", service="/switch", id=asked["id"], values=[True], result=True)
    assert (await peer.receive())["values"] == {"success": True, "message": ""}
    house.node("control").create_service(HoldPart, HOLD_PART, lambda _: zero_message(LeaseState))
    await peer.send("call_service", service=HOLD_PART, args={"part": "1"})
    assert "field 'device' is missing" in (await peer.receive())["values"]


async def test_a_list_of_arguments_fills_the_fields_in_order(house: House, peer: Peer) -> None:
    house.node("lamp").create_service(SetBool, "/switch", echo)
    await peer.send("call_service", service="/switch", args=[True])
    assert (await peer.receive())["values"]["success"] is True
    await peer.send("call_service", service="/switch", args=[True, 2])
    assert "has 1 fields, got 2 values" in (await peer.receive())["values"]


@pytest.mark.parametrize(
    ("service", "args", "problem"),
    [
        ("/nobody", {}, "service /nobody has no server now; /rosapi/services lists all$"),
        ("/swich", {}, "service /swich has no server now; did you mean /switch?"),
        ("bad name", {}, "has a character that is not allowed in names"),
        ("/switch", {"data": "yes"}, "field 'data': .*got 'yes'"),
        ("/switch", {"data": True, "more": 1}, "field 'more' is unknown"),
        ("/raises", {}, "RuntimeError: the bulb is broken"),
    ],
)
async def test_a_failed_call_says_why(
    house: House, peer: Peer, service: str, args: dict[str, Any], problem: str
) -> None:
    def broken(_request: TriggerRequest) -> SuccessResponse:
        raise RuntimeError("the bulb is broken")

    node = house.node("lamp")
    node.create_service(SetBool, "/switch", echo)
    node.create_service(Trigger, "/raises", broken)
    await peer.send("call_service", id="7", service=service, args=args)
    answer = await peer.receive()
    assert (answer["op"], answer["id"], answer["result"]) == ("service_response", "7", False)
    assert re.search(problem, answer["values"])


@pytest.mark.parametrize("ros_type", ["", "std_srvs/SetBool", "std_srvs/srv/SetBool"])
async def test_a_call_may_state_the_type_of_its_service(house: House, peer: Peer, ros_type: str) -> None:
    house.node("lamp").create_service(SetBool, "/switch", echo)
    await peer.send("call_service", service="/switch", type=ros_type, args=[True])
    assert (await peer.receive())["result"] is True


async def test_a_call_with_the_type_of_another_service_is_refused(house: House, peer: Peer) -> None:
    """A request that fits both would otherwise do what its sender does not expect."""
    house.node("lamp").create_service(Trigger, "/beep", lambda _: SuccessResponse(success=True, message="beep"))
    await peer.send("call_service", id="7", service="/beep", type="std_srvs/srv/Empty", args={})
    answer = await peer.receive()
    assert (answer["op"], answer["id"], answer["result"]) == ("service_response", "7", False)
    assert answer["values"] == "service /beep is a std_srvs/srv/Trigger, not a std_srvs/srv/Empty"


@pytest.mark.parametrize("stated", ["rosapi/GetActionServers", "rosapi_msgs/srv/ActionServers"])
async def test_a_service_of_rosapi_is_called_with_any_type(house: House, peer: Peer, stated: str) -> None:
    """ROS 1's, as roslib says, or one that no package has, as ros-mcp 3.1 says: the original ignores it."""
    await peer.send("call_service", service="/rosapi/action_servers", type=stated)
    assert (await peer.receive())["values"] == {"action_servers": []}


async def test_a_call_counts_until_its_handler_has_ended(open_house: Any) -> None:
    """Or a client with short time limits could have any number of handlers at work."""
    opened = anyio.Event()

    async def slow(_request: TriggerRequest) -> SuccessResponse:
        await opened.wait()
        return SuccessResponse(success=True, message="at last")

    async with (
        open_house(RosbridgeSettings(port=0, max_calls=1)) as house,
        house.node("lamp") as lamp,
        house.peer() as peer,
    ):
        lamp.create_service(Trigger, "/slow", slow, concurrent=True)
        await peer.send("call_service", service="/slow", timeout=0.05)
        assert "did not answer within 0.05 s" in (await peer.receive())["values"]
        await peer.send("call_service", id=2, service="/slow", timeout=60)
        answer = await peer.receive()
        assert (answer["id"], answer["values"]) == (2, "1 calls of this client are waiting already")
        opened.set()
        await peer.settle()
        await peer.send("call_service", service="/slow", timeout=60)
        assert (await peer.receive())["values"]["message"] == "at last"


async def test_a_client_that_never_answers_owes_nothing_for_callers_that_gave_up(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, max_calls=1)) as house, house.peer() as peer:
        await peer.tell("advertise_service", service="/mine", type="std_srvs/Trigger")
        node = house.node("app")
        client = node.create_client(Trigger, "/mine")
        for _ in range(2):
            with pytest.raises(ServiceTimeoutError):
                await client.call(TriggerRequest(), timeout=0.05)
        assert node.graph.failures.late_answers == 0


async def test_a_client_provides_a_service(house: House, peer: Peer) -> None:
    await peer.tell("advertise_service", service="mine", type="std_srvs/SetBool")
    client = house.node("app").create_client(SetBool, "/mine")
    call = asyncio.create_task(client.call(SetBoolRequest(data=True), timeout=PATIENCE))
    request = await peer.receive()
    assert (request["op"], request["service"], request["args"]) == ("call_service", "mine", {"data": True})
    values = {"success": True, "message": "by you"}
    await peer.send("service_response", id=request["id"], service="mine", values=values, result=True)
    assert await call == SetBoolResponse(success=True, message="by you")
    await peer.tell("unadvertise_service", service="mine")
    assert house.entities() == set()


@pytest.mark.parametrize(
    ("response", "problem"),
    [
        ({"result": False, "values": "no power"}, "no power"),
        ({"result": True, "values": {"success": 1}}, "field 'success'"),
        ({"result": True, "values": {"succes": True}}, "field 'succes' is unknown"),
    ],
)
async def test_a_bad_answer_of_a_client_fails_the_call(
    house: House, peer: Peer, response: dict[str, object], problem: str
) -> None:
    await peer.tell("advertise_service", service="/mine", type="std_srvs/Trigger")
    call = asyncio.create_task(house.node("app").create_client(Trigger, "/mine").call(TriggerRequest()))
    await peer.send("service_response", id=(await peer.receive())["id"], service="/mine", **response)
    with pytest.raises(ServiceFailedError, match=problem):
        await call


async def test_a_call_to_a_client_that_leaves_fails_at_once(house: House) -> None:
    client = house.node("app").create_client(Trigger, "/mine")
    async with house.peer() as peer:
        await peer.tell("advertise_service", service="/mine", type="std_srvs/Trigger")
        call = asyncio.create_task(client.call(TriggerRequest(), timeout=60))
        await peer.receive()
        await peer.connection.close()
        with anyio.fail_after(PATIENCE), pytest.raises(ServiceGoneError):
            await call
    assert not client.service_is_ready()


async def test_ids_of_two_clients_do_not_mix(house: House) -> None:
    """Roslibpy counts anew on every connection."""
    async with house.peer() as first, house.peer() as second:
        house.node("lamp").create_service(SetBool, "/switch", echo)
        await first.send("call_service", id="call_service:/switch:1", service="/switch", args={"data": True})
        await second.send("call_service", id="call_service:/switch:1", service="/switch", args={"data": False})
        assert (await first.receive())["values"]["success"] is True
        assert (await second.receive())["values"]["success"] is False


async def test_a_client_that_owes_too_many_answers_is_asked_no_more(open_house: Any) -> None:
    async with open_house(RosbridgeSettings(port=0, max_calls=1)) as house, house.peer() as peer:
        await peer.send("advertise_service", service="/mine", type="std_srvs/Trigger")
        await peer.tell("advertise_service", service="/mine", type="std_srvs/Trigger")
        client = house.node("app").create_client(Trigger, "/mine")
        first = asyncio.create_task(client.call(TriggerRequest()))
        await peer.receive()
        with pytest.raises(ServiceFailedError, match="has 1 calls waiting already"):
            await client.call(TriggerRequest())
        await peer.send("unadvertise_service", service="/mine")
        with pytest.raises(ServiceGoneError):
            await first


async def test_a_second_server_is_refused(house: House, peer: Peer) -> None:
    house.node("lamp").create_service(SetBool, "/switch", echo)
    await peer.send("set_level", level="error")
    await peer.send("advertise_service", id="a", service="/switch", type="std_srvs/SetBool")
    assert "already served by /lamp" in (await peer.receive())["msg"]


async def test_a_client_that_comes_back_provides_its_service_again(house: House) -> None:
    """Its old connection may be dead for long before that shows, and it offers the service once."""
    async with house.peer() as old, house.peer() as new:
        await old.tell("advertise_service", service="/mine", type="std_srvs/Trigger")
        await new.tell("advertise_service", service="mine", type="std_srvs/Trigger")
        assert "/mine is provided by a newer connection of the client local now" in (await old.receive())["msg"]
        await old.connection.close()
        while house.server.client_count > 1:
            await new.settle()
        client = house.node("app").create_client(Trigger, "/mine")
        call = asyncio.create_task(client.call(TriggerRequest(), timeout=PATIENCE))
        request, values = await new.receive(), {"success": True, "message": "here again"}
        await new.send("service_response", id=request["id"], service="mine", values=values, result=True)
        assert (await call).message == "here again"
        await new.tell("unadvertise_service", service="mine")
        assert house.entities() == set()


async def test_the_service_of_another_client_is_not_taken_over(open_house: Any) -> None:
    tokens = {name: ClientToken(token=SecretStr(name), scope=("read", "act: harmless")) for name in ("one", "two")}
    async with (
        open_house(RosbridgeSettings(port=0, tokens=tokens)) as house,
        house.peer(Authorization="Bearer one") as one,
        house.peer(Authorization="Bearer two") as two,
    ):
        await one.tell("advertise_service", service="/mine", type="std_srvs/Trigger")
        await two.send("advertise_service", service="/mine", type="std_srvs/Trigger")
        assert "already served by /rosbridge_websocket" in (await two.receive())["msg"]


async def test_a_value_is_written_as_it_is_in_json(house: House) -> None:
    async with house.node("control") as control, house.peer() as peer:
        held: list[object] = []

        def hold(request: HoldRequest) -> LeaseState:
            held.append(request.setting.value.plain())
            raise RefusedError("the hold", "this is a test")

        control.create_service(HoldPart, HOLD_PART, hold)
        fields = {"device": "lamp", "lease": "l", "by": "robot", "ttl": 9, "issuer": ""}
        plain: list[object] = [True, 40, "warm", [30.0, 0.5], None, {"type": 2, "number": 0.5}]
        for value in plain:
            await peer.call(HOLD_PART, setting={"capability": "x", "value": value}, **fields)
        assert held == [True, 40.0, "warm", (30.0, 0.5), None, 0.5]


async def test_a_client_that_vanishes_while_it_holds_a_lease_is_cut_off(house: House) -> None:
    """Then its leases end."""
    async with house.node("control") as control, house.peer() as peer:

        async def hold(_request: HoldRequest) -> LeaseState:
            await anyio.sleep_forever()
            raise AssertionError

        control.create_service(HoldPart, HOLD_PART, hold)
        wanted = {"capability": "on", "value": True}
        fields = {"device": "lamp", "lease": "l", "by": "robot", "ttl": 99, "setting": wanted, "issuer": ""}
        await peer.send("call_service", service=HOLD_PART, args=fields)
        await peer.tell("advertise", topic="/alive", type="std_msgs/Bool")
        peer.connection.transport.pause_reading()
        began = anyio.current_time()
        with house.graph.watch() as changes, anyio.fail_after(PATIENCE):
            while (await anext(changes)).entity.name != "/alive":
                pass
        assert 0.4 < anyio.current_time() - began < 5
        peer.connection.transport.abort()
