"""The index of the graph's entities against a plain list of them."""

from hypothesis import given
from hypothesis import strategies as st

from homebot.graph.endpoint import EndpointIndex, EndpointInfo, EntityKind

INFOS = st.builds(
    EndpointInfo,
    kind=st.sampled_from(EntityKind),
    node=st.sampled_from(["/a", "/b"]),
    name=st.sampled_from(["/s", "/t", "/u"]),
    ros_type=st.sampled_from(["std_msgs/msg/Bool", "std_msgs/msg/String"]),
)


class Entity:
    """Something on the graph."""


@given(infos=st.lists(INFOS, max_size=30), data=st.data())
def test_it_finds_what_a_look_at_everything_finds_in_the_same_order(
    infos: list[EndpointInfo], data: st.DataObject
) -> None:
    index = EndpointIndex()
    entities = [(Entity(), info) for info in infos]
    for entity, info in entities:
        index.add(entity, info)
    gone = data.draw(st.sets(st.integers(0, max(0, len(entities) - 1)), max_size=len(entities)))
    removed = [index.remove(entities[place][0]) for place in sorted(gone) if place < len(entities)]
    assert removed == [entities[place][1] for place in sorted(gone) if place < len(entities)]
    left = [info for place, (_, info) in enumerate(entities) if place not in gone]

    kind = data.draw(st.sampled_from([None, *EntityKind]))
    name = data.draw(st.sampled_from([None, "/s", "/t", "/absent"]))
    node = data.draw(st.sampled_from([None, "/a", "/absent"]))
    assert list(index.find(kind, name, node)) == [
        info for info in left if kind in {None, info.kind} and name in {None, info.name} and node in {None, info.node}
    ]
    for kind in EntityKind:
        firsts = [*index.first_of_each_type(kind)]
        assert {one.ros_type for one in firsts} == {info.ros_type for info in left if info.kind is kind}
        for first in firsts:
            fitting = [info for info in left if info.kind is kind and info.ros_type == first.ros_type]
            assert list(index.of_type(kind, first.ros_type)) == fitting
            assert first == fitting[0]
    assert index.remove(Entity()) is None
