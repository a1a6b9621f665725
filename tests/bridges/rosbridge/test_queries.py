"""Queries through the door: clients may write them as text, the graph carries terms."""

import re

import pytest
from tests.bridges.conftest import House, Peer

from homebot.devices import FIND_DEVICES, QUERY_DEVICES, FindDevices, QueryDevices
from homebot.devices.query.term_messages import query_terms, read_terms
from homebot.devices.query.terms import And, Query
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse, QueryDevicesRequest, QueryDevicesResponse
from homebot.graph import Node
from homebot.messages.json import message_to_json
from homebot.words.queries import parse_query

ON_LIGHTS = parse_query("on lights in kitchen")


class FakeDirectory:
    """A directory of no devices, which notes the queries that it gets."""

    def __init__(self, node: Node) -> None:
        self.asked: list[Query] = []
        self.is_checked = False
        node.create_service(FindDevices, FIND_DEVICES, self._find)
        node.create_service(QueryDevices, QUERY_DEVICES, self._query)

    def _find(self, request: FindDevicesRequest) -> FindDevicesResponse:
        self.is_checked = request.is_checked
        self.asked.append(read_terms(request.query, parse_query))
        return FindDevicesResponse(devices=(), sequence=7)

    def _query(self, request: QueryDevicesRequest) -> QueryDevicesResponse:
        self.asked.append(read_terms(request.query, parse_query))
        return QueryDevicesResponse(success=True, sequence=7)


@pytest.mark.parametrize("service", [FIND_DEVICES, QUERY_DEVICES])
@pytest.mark.parametrize(
    ("sent", "meant"),
    [
        ({"query": "on lights in kitchen"}, ON_LIGHTS),
        ({"query": [message_to_json(term) for term in query_terms(ON_LIGHTS)]}, ON_LIGHTS),
        ({"query": ""}, And(())),
        ({}, And(())),
    ],
    ids=["text", "terms", "empty text", "nothing"],
)
async def test_a_query_is_sent_as_text_or_as_terms(
    house: House, peer: Peer, service: str, sent: dict[str, object], meant: Query
) -> None:
    directory = FakeDirectory(house.node("directory"))
    assert (await peer.call(service, **sent))["result"] is True
    assert directory.asked == [meant]


@pytest.mark.parametrize("sent", [{}, {"is_checked": False}])
async def test_the_names_in_a_question_of_a_program_outside_are_checked(
    house: House, peer: Peer, sent: dict[str, object]
) -> None:
    directory = FakeDirectory(house.node("directory"))
    assert (await peer.call(FIND_DEVICES, service_type="lihgts", **sent))["result"] is True
    assert directory.is_checked == sent.get("is_checked", True)


async def test_a_list_of_arguments_may_have_a_text_query(house: House, peer: Peer) -> None:
    directory = FakeDirectory(house.node("directory"))
    await peer.send("call_service", service=QUERY_DEVICES, args=["on lights in kitchen", 0, 5])
    assert (await peer.receive())["result"] is True
    assert directory.asked == [ON_LIGHTS]


async def test_a_search_by_an_invalid_text_answers_the_problem(house: House, peer: Peer) -> None:
    FakeDirectory(house.node("directory"))
    answer = await peer.call(QUERY_DEVICES, query="brightnes > 3")
    assert answer["result"] is True
    assert "did you mean brightness?" in answer["values"].pop("message")
    assert answer["values"] == {
        "success": False,
        "results": [],
        "total": 0,
        "sequence": 7,
        "is_mistake": True,
        "left_out": [],
        "pose_age": 0.0,
        "query": [],
    }


async def test_a_call_with_a_text_that_is_no_query_fails_where_the_answer_has_no_place_for_the_reason(
    house: House, peer: Peer
) -> None:
    FakeDirectory(house.node("directory"))
    answer = await peer.call(FIND_DEVICES, query="(light")
    assert answer["result"] is False
    assert answer["values"] == "the bracket at character 1 is never closed"


@pytest.mark.parametrize(
    ("args", "problem"),
    [
        ({"query": 5}, "field 'query': input should be a valid tuple, got 5"),
        ({"query": [{"kind": "nor"}]}, "field 'query.0.kind': .*got 'nor'"),
        ({"query": "(light", "limit": -1}, "field 'limit'"),
        ({"query": "light", "order": "name"}, "field 'order' is unknown"),
    ],
)
async def test_a_field_of_another_type_is_refused_before_anything_is_asked(
    house: House, peer: Peer, args: dict[str, object], problem: str
) -> None:
    directory = FakeDirectory(house.node("directory"))
    answer = await peer.call(QUERY_DEVICES, **args)
    assert answer["result"] is False
    assert directory.asked == []
    assert re.search(problem, answer["values"])


async def test_any_query_without_a_directory_fails_for_that_reason(peer: Peer) -> None:
    answer = await peer.call(QUERY_DEVICES, query="(light")
    assert answer["result"] is False
    assert answer["values"].startswith(f"service {QUERY_DEVICES} has no server now")
