"""The scenes that an endpoint keeps for the fabric. Pure.

Each is of one endpoint, also one with the number of a group: a server sends no messages to groups.

Source: Matter 1.4 Application Clusters, 1.4 (Scenes Management); Matter 1.4 Core Specification, 11.2.6 (GroupTable).
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from homebot.conventions.command_values import require_transition
from homebot.conventions.payload import as_fields, clean_text
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Part, SceneValue
from homebot.devices.value import Value
from homebot.integrations.matter.formats.cluster_row import ClusterRow, cluster_row
from homebot.integrations.matter.formats.endpoint import (
    ClusterInvocation,
    MatterEndpoint,
    MatterOrders,
    MatterScene,
    field_of,
)
from homebot.support.numbers import whole_number

SCENES: Final = 98
_SCENE_INFO: Final = 2
_GROUP_KEYS, _GROUP_TABLE = 63, 1
_MAX_SCENES: Final = 50
_MAX_TRANSITION_S: Final = 60_000.0
"""Seconds of a transition."""


def scene_count(endpoint: MatterEndpoint) -> int:
    """Return the number of scenes that an endpoint keeps, perhaps with those for other fabrics."""
    counts = (whole_number(field_of(struct, 0, "sceneCount")) for struct in endpoint.structs(SCENES, _SCENE_INFO))
    return sum(count for count in counts if count is not None and count > 0)


def groups_at(root: MatterEndpoint, endpoint: MatterEndpoint) -> tuple[int, ...]:
    """Return the numbers of the groups that may have scenes at an endpoint: 0, and those that it is in."""
    groups = [0]
    for struct in root.structs(_GROUP_KEYS, _GROUP_TABLE):
        group, endpoints = whole_number(field_of(struct, 1, "groupId")), field_of(struct, 2, "endpoints")
        if group and isinstance(endpoints, list) and endpoint.id in endpoints:
            groups.append(group)
    return tuple(dict.fromkeys(groups[:_MAX_SCENES]))


def scenes_of(group: int) -> ClusterInvocation:
    """Return the question for the numbers of the scenes of a group."""
    return ClusterInvocation(SCENES, "GetSceneMembership", {"groupID": group})


def scene_numbers(answer: object) -> tuple[int, ...]:
    """Return the numbers in the answer to :func:`scenes_of`."""
    listed = _named(answer).get("scenelist")
    return tuple([number for number in listed[:_MAX_SCENES] if type(number) is int]) if isinstance(listed, list) else ()


def read_scene(group: int, number: int, answer: object) -> MatterScene:
    """Return the scene that an *answer* to ``ViewScene`` describes."""
    fields, clusters = _named(answer), dict[int, dict[int, object]]()
    for struct in _structs(fields.get("extensionfieldsetstructs")):
        for pair in _structs(struct.get("attributevaluelist", struct.get("1"))):
            cluster = whole_number(struct.get("clusterid", struct.get("0")))
            attribute = whole_number(pair.get("attributeid", pair.get("0")))
            given = [value for key, value in pair.items() if key not in {"attributeid", "0"} and value is not None]
            if cluster is not None and attribute is not None and given:
                clusters.setdefault(cluster, {})[attribute] = given[0]
    name = fields.get("scenename")
    return MatterScene(group, number, clean_text(name) if isinstance(name, str) else "", clusters)


def scene_parts(
    endpoint: MatterEndpoint, member: str, rows: Iterable[ClusterRow]
) -> Iterator[tuple[Part, MatterEndpoint, tuple[ClusterRow, ...]]]:
    """Yield the part that recalls each scene of an endpoint, with the endpoint as it is then, and its row.

    Args:
        member: The name of the endpoint's part as a member of groups; empty for none.
        rows: Those of this part.
    """
    for scene in endpoint.scenes:
        then = MatterEndpoint(endpoint.id)
        then.clusters = {
            cluster: _overlaid(known, scene.clusters.get(cluster, {})) for cluster, known in endpoint.clusters.items()
        }
        part = Part(
            id=f"{endpoint.id}-{scene.part_id}",
            name=scene.name or f"Scene {scene.number}",
            service_type="x_scene",
            advertised="scene",
            capabilities=tuple(
                [capability for capability in [_recall(scene).describe(then)] if capability is not None]
            ),
            members=(member,) if member else (),
            values=tuple(_values(scene, then, member, rows)) if member else (),
            fades=True,
        )
        yield part, then, (_recall(scene),)


def _overlaid(known: Mapping[int, object], values: Mapping[int, object]) -> dict[int, object]:
    """Return the attributes *known* with the *values* of a scene, which has numbers for booleans too."""
    flags = {attribute for attribute, value in known.items() if isinstance(value, bool)}
    return {**known, **{attribute: bool(value) if attribute in flags else value for attribute, value in values.items()}}


def _values(scene: MatterScene, then: MatterEndpoint, member: str, rows: Iterable[ClusterRow]) -> Iterator[SceneValue]:
    """Yield the values that a scene sets; nothing if homebot does not know all of them."""
    settings = {
        row.capability: (row.watched[0], row.read(then))
        for row in rows
        if row.read is not None and row.write is not None and row.watched[0] in scene.clusters
    }
    if "position" in settings:
        settings.pop("movement", None)
    is_off = settings.get("on_off", (0, None))[1] is False
    if scene.clusters.keys() - {cluster for cluster, value in settings.values() if is_off or value is not None}:
        return
    for capability, (_, value) in settings.items():
        if value is not None and (capability == "on_off" or not is_off):
            yield SceneValue(member=member, capability=capability, value=Value.of(value))


def _recall(scene: MatterScene) -> ClusterRow:
    def write(_at: MatterEndpoint, command: Command) -> MatterOrders:
        payload: dict[str, object] = {"groupID": scene.group, "sceneID": scene.number}
        if command.transition:
            payload["transitionTime"] = round(require_transition(command.transition, _MAX_TRANSITION_S) * 1000)
        return (ClusterInvocation(SCENES, "RecallScene", payload),)

    return cluster_row(SCENES, None, "scene", write=write)


def _structs(listed: object) -> Iterator[Mapping[str, object]]:
    return map(_named, listed[:_MAX_SCENES] if isinstance(listed, list) else ())


def _named(struct: object) -> Mapping[str, object]:
    """Return the fields of a struct: servers write ``groupID`` or ``groupId``, or the number as text."""
    return {key.casefold(): value for key, value in as_fields(struct).items()}
