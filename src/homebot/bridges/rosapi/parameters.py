"""Parameters of any node by one name, ``/node:parameter``, with values as JSON text."""

from __future__ import annotations

import json
from typing import Any

from homebot.bridges.rosapi.parameter_messages import (
    DeleteParamRequest,
    DeleteParamResponse,
    GetParamNamesRequest,
    GetParamNamesResponse,
    GetParamRequest,
    GetParamResponse,
    HasParamRequest,
    HasParamResponse,
    SetParamRequest,
    SetParamResponse,
)
from homebot.errors import ParameterError
from homebot.graph import Graph, ParameterSet
from homebot.strict_json import parse_strict

__all__ = ["GraphParameters"]


class GraphParameters:
    """The parameters of every node of *graph*."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def get(self, request: GetParamRequest) -> GetParamResponse:
        """Return a value; where there is none, the caller's default."""
        try:
            parameters, name = self._find(request.name)
            value = parameters.get(name).value
        except ParameterError as exc:
            return GetParamResponse(value=request.default_value or "null", successful=False, reason=str(exc))
        plain = list(value) if isinstance(value, bytes) else value
        return GetParamResponse(value=json.dumps(plain), successful=True, reason="")

    def set(self, request: SetParamRequest) -> SetParamResponse:
        """Set a value."""
        try:
            parameters, name = self._find(request.name)
            value: Any = parse_strict(request.value)  # the parameter checks it
            if isinstance(parameters.get(name).value, bytes) and isinstance(value, list):
                value = bytes(value)
            parameters.set(name, value)
        except (ParameterError, ValueError, TypeError, RecursionError) as exc:
            return SetParamResponse(successful=False, reason=f"{request.name}: {exc}")
        return SetParamResponse(successful=True, reason="")

    def delete(self, request: DeleteParamRequest) -> DeleteParamResponse:
        """Refuse: a parameter belongs to the node that declared it."""
        reason = f"{request.name}: a parameter stays as long as the node that declared it"
        try:
            parameters, name = self._find(request.name)
            parameters.get(name)
        except ParameterError as exc:
            reason = str(exc)
        return DeleteParamResponse(successful=False, reason=reason)

    def has(self, request: HasParamRequest) -> HasParamResponse:
        """Tell whether a parameter is declared."""
        try:
            parameters, name = self._find(request.name)
        except ParameterError:
            return HasParamResponse(exists=False)
        return HasParamResponse(exists=parameters.has(name))

    def names(self, _request: GetParamNamesRequest) -> GetParamNamesResponse:
        """Return all names."""
        nodes = [node for name in self._graph.get_node_names() if (node := self._graph.get_node(name)) is not None]
        names = (f"{node.full_name}:{name}" for node in nodes for name in node.parameters.names())
        return GetParamNamesResponse(names=tuple(names))

    def _find(self, full_name: str) -> tuple[ParameterSet, str]:
        node_name, colon, name = full_name.rpartition(":")
        if not colon:
            raise ParameterError(f"a parameter is named /node:parameter, got {full_name[:100]!r}")
        node = self._graph.get_node(node_name if node_name.startswith("/") else f"/{node_name}")
        if node is None:
            raise ParameterError(f"there is no node {node_name[:100]!r}")
        return node.parameters, name
