"""The routes of the HTTP API, their description in OpenAPI 3.1, and answers to requests.

The question is read and checked, and every error of homebot becomes a problem.
"""

import json
from collections.abc import Awaitable, Callable
from functools import cache
from http import HTTPStatus
from typing import Any, Final, NamedTuple
from urllib.parse import parse_qsl, unquote, urlsplit

from pydantic import BaseModel, ValidationError
from pydantic.json_schema import models_json_schema

from homebot.bridges.home_api import answers, shapes
from homebot.bridges.home_api.device_search import HomeCalls
from homebot.bridges.home_api.shapes import PROBLEMS, Problem, ProblemError
from homebot.errors import HomebotError, UsageError
from homebot.feature import all_features, load
from homebot.version import __version__

_JSON: Final = "application/json"
_OPENAPI: Final = "/api/openapi.json"
_REFERENCE: Final = "#/components/schemas/{model}"


class ApiRoute(NamedTuple):
    """One route; ``{id}`` stands at the end of its path and may have slashes."""

    method: str
    path: str
    question: type[BaseModel]
    answer: type[BaseModel]
    handle: Callable[[HomeCalls, Any], Awaitable[BaseModel]]


_CORE_ROUTES: Final = (
    ApiRoute("GET", "/api/home", shapes.NoQuestion, shapes.HomeAnswer, answers.home_in_short),
    ApiRoute("GET", "/api/devices", shapes.ListQuestion, shapes.DeviceList, answers.find_devices),
    ApiRoute("GET", "/api/devices/{id}", shapes.DeviceQuestion, shapes.DeviceDetails, answers.device_details),
    ApiRoute("POST", "/api/command", shapes.CommandQuestion, shapes.OutcomeAnswer, answers.command),
    ApiRoute("GET", "/api/why/{id}", shapes.WhyQuestion, shapes.WhyAnswer, answers.why),
    ApiRoute("GET", "/api/journal", shapes.JournalQuestion, shapes.JournalAnswer, answers.journal),
)


@cache
def all_routes() -> tuple[ApiRoute, ...]:
    """Return the routes of the core and of all features."""
    return (*_CORE_ROUTES, *(route for feature in all_features() if feature.routes for route in load(feature.routes)))


@cache
def openapi_text() -> bytes:
    """Return the description as JSON."""
    models: list[type[BaseModel]] = [shapes.Problem, *(route.answer for route in all_routes())]
    models += [route.question for route in all_routes() if route.method == "POST"]
    _, schemas = models_json_schema([(model, "serialization") for model in models], ref_template=_REFERENCE)
    paths: dict[str, Any] = {}
    for route in all_routes():
        paths.setdefault(route.path, {})[route.method.lower()] = _operation(route)
    document = {
        "openapi": "3.1.0",
        "info": {"title": "homebot", "version": __version__},
        "security": [{}, {"token": []}],
        "paths": paths,
        "components": {
            "schemas": schemas["$defs"],
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
    }
    return json.dumps(document, separators=(",", ":")).encode()


def _operation(route: ApiRoute) -> dict[str, Any]:
    answer = {"description": "Done.", "content": {"application/json": {"schema": _named(route.answer)}}}
    problem = {"content": {"application/problem+json": {"schema": _named(shapes.Problem)}}}
    too_long = {"description": "The address is longer than 8 KiB.", "content": {"text/plain": {}}}
    problems = {str(status.value): {"description": status.phrase, **problem} for status in shapes.PROBLEMS}
    operation: dict[str, Any] = {
        "operationId": route.handle.__name__,
        "summary": (route.handle.__doc__ or "").partition("\n")[0],
        "responses": {"200": answer, "414": too_long, **problems},
    }
    if route.method == "POST":
        content = {"application/json": {"schema": _named(route.question)}}
        return {**operation, "requestBody": {"required": True, "content": content}}
    schema = route.question.model_json_schema(ref_template=_REFERENCE)
    return {
        **operation,
        "parameters": [
            {
                "name": name,
                "in": "path" if f"{{{name}}}" in route.path else "query",
                "required": name in schema.get("required", ()),
                "schema": field,
            }
            for name, field in schema.get("properties", {}).items()
        ],
    }


def _named(model: type[BaseModel]) -> dict[str, str]:
    return {"$ref": _REFERENCE.format(model=model.__name__)}


class ApiAnswer(NamedTuple):
    """The answer to a request.

    Attributes:
        allow: With 405, the methods of the address.
    """

    status: HTTPStatus
    content_type: str
    body: bytes
    allow: str = ""


class ApiRequest(NamedTuple):
    """A request as it came; its target is path and query."""

    method: str
    target: str
    content_type: str = ""
    body: bytes = b""


async def answer(request: ApiRequest, home: HomeCalls) -> ApiAnswer:
    """Return the answer to *request*; never raises an error of homebot."""
    try:
        if (request.method, urlsplit(request.target).path) == ("GET", _OPENAPI):
            return ApiAnswer(HTTPStatus.OK, _JSON, openapi_text())
        route, question = _question(request)
        result = await route.handle(home, question)
    except ProblemError as exc:
        return problem_body(exc.status, str(exc))._replace(allow=exc.allow)
    except UsageError as exc:
        return problem_body(HTTPStatus.BAD_REQUEST, str(exc))
    except HomebotError as exc:
        return problem_body(HTTPStatus.SERVICE_UNAVAILABLE, str(exc))
    return ApiAnswer(HTTPStatus.OK, _JSON, _text(result))


def problem_body(status: HTTPStatus, detail: str) -> ApiAnswer:
    """Return the answer that reports an error."""
    problem = Problem(title=status.phrase, status=status, outcome=PROBLEMS[status], detail=detail)
    return ApiAnswer(status, "application/problem+json", _text(problem))


def _text(model: BaseModel) -> bytes:
    return model.model_dump_json(exclude_defaults=True).encode() + b"\n"


def _question(request: ApiRequest) -> tuple[ApiRoute, BaseModel]:
    url = urlsplit(request.target)
    fitting = [route for route in all_routes() if _fits(route.path, url.path)]
    if not fitting:
        known = ", ".join([*(f"{route.method} {route.path}" for route in all_routes()), f"GET {_OPENAPI}"])
        raise ProblemError(HTTPStatus.NOT_FOUND, f"there is no {url.path[:100]}; there are {known}")
    route = next((route for route in fitting if route.method == request.method), None)
    if route is None:
        methods = ", ".join(route.method for route in fitting)
        raise ProblemError(HTTPStatus.METHOD_NOT_ALLOWED, f"{fitting[0].path} takes {methods}", methods)
    is_post = route.method == "POST"
    if is_post and request.content_type.partition(";")[0].strip().lower() != _JSON:
        raise ProblemError(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, f"send the header Content-Type: {_JSON}")
    try:
        if is_post:
            return route, route.question.model_validate_json(request.body)
        if request.body:
            raise ProblemError(HTTPStatus.BAD_REQUEST, "fields of GET belong in the address, as in ?q=light")
        fields = dict(parse_qsl(url.query, keep_blank_values=True))
        if route.path.endswith("{id}"):
            fields["id"] = unquote(url.path[len(route.path) - len("{id}") :])
        return route, route.question.model_validate(fields)
    except ValidationError as exc:
        raise _wrong_field(route, exc) from None


def _wrong_field(route: ApiRoute, exc: ValidationError) -> ProblemError:
    errors = exc.errors(include_url=False)
    wrong = next((error for error in errors if not error["type"].endswith("_type")), errors[0])  # one for each type
    field, *inner = wrong["loc"] or ("body",)
    where = ".".join(map(str, (field, *(key for key in inner if isinstance(key, int) or key.isidentifier()))))
    known = ", ".join(route.question.model_fields) or "none"
    return ProblemError(HTTPStatus.BAD_REQUEST, f"{where[:100]}: {wrong['msg']}; known are {known}")


def _fits(pattern: str, path: str) -> bool:
    return path.startswith(pattern[: -len("{id}")]) if pattern.endswith("{id}") else path == pattern
