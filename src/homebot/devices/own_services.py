"""The services and actions of homebot itself, each with the right that a client needs. Pure."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import TYPE_CHECKING, Final

from homebot.devices import names
from homebot.feature import feature_services
from homebot.rights import OfferedService, Right

if TYPE_CHECKING:
    from collections.abc import Mapping

CORE_SERVICES: Final = (
    OfferedService("*/describe_parameters", Right.READ),
    OfferedService("*/get_parameter_types", Right.READ),
    OfferedService("*/get_parameters", Right.READ),
    OfferedService("*/health", Right.READ),
    OfferedService("*/list_parameters", Right.READ),
    OfferedService("*/set_parameters", Right.MANAGE),
    OfferedService("*/set_parameters_atomically", Right.MANAGE),
    # A goal sent to it directly would keep the client's choice of issuer, and outlive its connection.
    OfferedService("/*/_action/send_goal", Right.RAW),
    OfferedService("/*/_action/cancel_goal", Right.MANAGE),
    OfferedService("/*/_action/get_result", Right.MANAGE),
    OfferedService("/gateway/*", Right.MANAGE),
    *(OfferedService(f"/gateway/*/{name}", Right.READ) for name in sorted(names.GATEWAY_READING)),
    OfferedService("/gateway/*/refresh", Right.ACT),
    OfferedService("/gateway/*/send_command", Right.RAW),
    OfferedService("/rosapi/*", Right.READ),
    OfferedService("/rosapi/delete_param", Right.MANAGE),
    OfferedService("/rosapi/set_param", Right.MANAGE),
    OfferedService("/subscribe_to_mqtt_topic", Right.READ),
    OfferedService(names.ALIAS_DEVICE, Right.MANAGE),
    OfferedService(names.ANSWER_QUESTION, Right.ACT),
    OfferedService(names.APPROVE_DEVICE, Right.MANAGE),
    OfferedService(names.CHANGE_ROOM, Right.MANAGE),
    OfferedService(names.COMMAND_DEVICES, Right.ACT, waits=True),
    OfferedService(names.COPY_FILES, Right.MANAGE),
    OfferedService(names.DEFINE_TYPE, Right.ACT),
    OfferedService(names.END_LEASES, Right.MANAGE),
    OfferedService(names.EXPLAIN_DEVICE, Right.READ),
    OfferedService(names.EXPLAIN_MISSING_STATE, Right.READ),
    OfferedService(names.EXPORT_INDEX, Right.MANAGE),
    OfferedService(names.EXPORT_PLACES, Right.READ),
    OfferedService(names.FIND_DEVICES, Right.READ),
    OfferedService(names.FORGET_DEVICE, Right.MANAGE),
    OfferedService(names.GET_CAUSES, Right.READ),
    OfferedService(names.GET_CHANGES, Right.READ),
    OfferedService(names.GET_INDEX_DATA, Right.READ),
    OfferedService(names.GET_LEASES, Right.READ),
    OfferedService(names.GET_PLACES, Right.READ),
    OfferedService(names.GET_QUESTIONS, Right.READ),
    OfferedService(names.GET_UNAPPROVED, Right.READ),
    OfferedService(names.HOLD_DEVICE, Right.ACT),
    OfferedService(names.HOLD_PART, Right.ACT, waits=True),
    OfferedService(names.HOME_PLACE, Right.ACT),
    OfferedService(names.IMPORT_PLACES, Right.MANAGE),
    OfferedService(names.LIST_APPS, Right.READ),
    OfferedService(names.LIST_DEVICES, Right.READ),
    OfferedService(names.LIST_GROUPS, Right.READ),
    OfferedService(names.LIST_TOKENS, Right.MANAGE),
    OfferedService(names.LOAD_APP, Right.MANAGE),
    OfferedService(names.MERGE_DEVICES, Right.MANAGE),
    OfferedService(names.PERFORM_COMMAND, Right.ACT, waits=True),
    OfferedService(names.PERFORM_COMMANDS, Right.ACT),
    OfferedService(names.PLACE_DEVICE, Right.MANAGE),
    OfferedService(names.QUERY_DEVICES, Right.READ),
    OfferedService(names.READ_JOURNAL, Right.READ),
    OfferedService(names.RELEASE_LEASE, Right.ACT),
    OfferedService(names.RELOAD, Right.MANAGE),
    OfferedService(names.RELOAD_APP, Right.MANAGE),
    OfferedService(names.RENEW_LEASE, Right.ACT),
    OfferedService(names.RESTART_GATEWAY, Right.MANAGE),
    OfferedService(names.SEND_TEXT, Right.ACT, waits=True),
    OfferedService(names.SPLIT_DEVICE, Right.MANAGE),
    OfferedService(names.TAG_DEVICE, Right.MANAGE),
    OfferedService(names.TEACH_PLACE, Right.MANAGE),
    OfferedService(names.TRUST_DEVICE, Right.MANAGE),
    OfferedService(names.UNLOAD_APP, Right.MANAGE),
    OfferedService(names.WHERE_IS_ROBOT, Right.READ),
)
"""By name; ``*/NAME`` is of any node, also that of an app, and another ``*`` is any name without a row."""


@cache
def _rows() -> Mapping[str, OfferedService]:
    """Return all rows by name; no feature of another package changes one of the core."""
    return {**feature_services(), **{row.name: row for row in CORE_SERVICES}}


@cache
def own_namespaces() -> frozenset[str]:
    """Return the first parts of the names of homebot's own topics and services."""
    return names.OWN_NAMESPACES | {name.split("/", 2)[1] for name in feature_services()}


def is_own(name: str) -> bool:
    """Return whether the topic, service or action with the full *name* is homebot's own."""
    return name.split("/", 2)[1] in own_namespaces()


@lru_cache(maxsize=1024)
def row_of_service(name: str) -> OfferedService | None:
    """Return the row of the service or action with the full *name*; None if there is none."""
    first, *path = name.split("/")[1:]
    last = path[-1] if path else first
    rows = _rows()
    if (row := rows.get(f"*/{last}")) is not None or not is_own(name):
        return row
    keys = (name, f"/*/_action/{last}" if path[-2:-1] == ["_action"] else "", f"/{first}/*/{last}", f"/{first}/*")
    return next((rows[key] for key in keys if key in rows), None)


def right_to_call(name: str) -> Right:
    """Return the right needed to call the service, or to send a goal to the action, with the full *name*.

    A name among homebot's own without a row is a mistake of the client, as homebot starts with no such service.
    """
    row = row_of_service(name)
    if row is not None:
        return row.right
    return Right.MANAGE if is_own(name) else Right.ACT
