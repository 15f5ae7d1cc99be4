"""Reading the JSON of a house: huge input is refused early, and every mistake is explained in plain words.

Sizes are checked first, because validation would take long on huge input. Messages are made from the JSON Schema of the
format, so that the valid values in a message always agree with the schema.
"""

import json
import math
import re
import textwrap
from collections import Counter, defaultdict
from collections.abc import Sequence
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from worlds.errors import SpecError
from worlds.valid_names import did_you_mean

MAX_JSON_BYTES = 16_000_000
MAX_VALUES = 2_000_000
_MAX_FIELDS = 100
MAX_MISTAKES = 20
"""Greatest number of malformed fields that are explained one by one."""
_MAX_LINE = 380
"""Greatest number of characters in a message."""
_CONTENTS = "valid: a house as JSON"
_TOO_DEEP = f"is nested too deeply; {_CONTENTS}"
_IDENTIFIER = "a name of 1 to 64 letters, digits, spaces and _ . ' -, the first a letter or digit"
_UNIT = re.compile(r"\[(?:m|rad)\]")
_PATH = tuple[str | int, ...]


def read_json(text: str, schema: dict[str, Any]) -> object:
    """Parse a JSON text; `schema` gives the greatest lengths of its lists.

    Raises `SpecError` if the text is not JSON, is huge, repeats a field in an object, or is nested too deeply.
    """
    if len(text) > MAX_JSON_BYTES:
        raise SpecError(f"larger than {MAX_JSON_BYTES // 1_000_000} MB; {_CONTENTS}")
    if text.count(",") >= MAX_VALUES:
        raise SpecError(f"more than {MAX_VALUES} values; a house of 200 rooms has far fewer")
    try:
        data = json.loads(text)
        _check_sizes(data, (), schema, schema)
        json.loads(text, object_pairs_hook=fields_once)
    except json.JSONDecodeError as error:
        what = error.msg.removesuffix(" at")
        raise SpecError(f"is not JSON: {what} at line {error.lineno} column {error.colno}; {_CONTENTS}") from None
    except RecursionError:
        raise SpecError(_TOO_DEEP) from None
    except SpecError:
        raise
    except ValueError:
        raise SpecError("has a number of more digits than any number of a house; valid: numbers as in 3.25") from None
    return data


def fields_once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Return the fields of a JSON object as a dict. Raises `SpecError` for a repeated field, which JSON itself permits."""
    fields = dict(pairs)
    if len(fields) < len(pairs):
        key, times = Counter(key for key, _ in pairs).most_common(1)[0]
        owner = fields.get("id", fields.get("name", fields.get("rooms")))
        raise SpecError(f"an object ({_shown(owner)}) has the field {_shown(key)} {times} times; valid: once")
    return fields


def _check_sizes(data: object, path: _PATH, node: dict[str, Any], schema: dict[str, Any]) -> None:
    """Raise `SpecError` for lists and objects that are too long, so that validation does not look at all their items."""
    node = _resolved(node, schema)
    if isinstance(data, list) and "items" in node:
        if len(data) > node["maxItems"]:
            raise SpecError(f"{_path(path)}: has {len(data)} items; valid: {_described(node, schema)}")
        for i, item in enumerate(data):
            _check_sizes(item, (*path, i), node["items"], schema)
    elif isinstance(data, dict):
        if len(data) > _MAX_FIELDS:
            raise SpecError(f"{_path(path) or 'the house'}: has {len(data)} fields; valid: at most {_MAX_FIELDS}")
        for key, described in node.get("properties", {}).items():
            if key in data:
                _check_sizes(data[key], (*path, key), described, schema)


def explain(error: ValidationError, data: object, schema: dict[str, Any]) -> list[str]:
    """Return one line for each malformed field: its place, its value and the valid values.

    After `MAX_MISTAKES` lines, a last line says how many malformed fields are left.
    """
    problems = [problem for problem in error.errors(include_url=False) if not _is_consequence(problem)]
    misspelt = defaultdict(list)
    for problem in problems:
        if problem["type"] == "extra_forbidden":
            misspelt[problem["loc"][:-1]].append(problem["loc"][-1])
    lines: dict[str, None] = {}
    for i, problem in enumerate(problems):
        if len(lines) >= MAX_MISTAKES:
            return [*lines, f"and {len(problems) - i} more malformed fields"]
        *parent, field = problem["loc"] or ("",)
        # A misspelt field is reported twice: as an unknown field and as a missing field. The first message says more.
        if problem["type"] != "missing" or not any(
            did_you_mean(str(wrong), [str(field)]) for wrong in misspelt[tuple(parent)]
        ):
            lines |= dict.fromkeys(_explained(problem, data, schema))
    return list(lines)


def _is_consequence(problem: ErrorDetails) -> bool:
    """Return whether pydantic reports a list as too short only because it does not count the list's malformed items."""
    return problem["type"] == "too_short" and len(problem["input"]) >= problem["ctx"]["min_length"]


def _explained(problem: ErrorDetails, data: object, schema: dict[str, Any]) -> list[str]:
    path: _PATH = problem["loc"]
    kind, value = problem["type"], problem["input"]
    if kind == "extra_forbidden":
        valid = list(_node(path[:-1], schema).get("properties", {}))
        unknown = f"{_place(path[:-1], data)}no field {_shown(path[-1])}{did_you_mean(str(path[-1]), valid)}"
        return [f"{unknown}; valid: {', '.join(valid)}"]
    if kind == "value_error":
        return [_place(path, data) + str(mistake) for mistake in problem["ctx"]["error"].args[:MAX_MISTAKES]]
    if kind == "json_invalid":
        why = problem["ctx"]["error"]
        return [_TOO_DEEP if why.startswith("recursion limit") else f"is not JSON: {why}; {_CONTENTS}"]
    if kind == "missing" and isinstance(path[-1], int):
        path, kind, value = path[:-1], "too_short", list(_at(data, path[:-1]))
    valid_here = _described(_node(path, schema), schema)
    if kind == "missing":
        return [f"{_place(path, data)}is missing; valid: {valid_here}"]
    if kind in ("too_short", "too_long") and isinstance(value, list):
        return [f"{_place(path, data)}has {len(value)} items; valid: {valid_here}"]
    return [f"{_place(path, data)}is {_shown(value)}; valid: {valid_here}"]


def mistakes_error(source: str, mistakes: Sequence[str]) -> SpecError:
    """Return an error whose message is the first mistake in a file and whose notes are the others; long lines are cut."""
    length = max(_MAX_LINE - len(source), _MAX_LINE // 2)
    first, *others = (f"{source}: {textwrap.shorten(mistake, length, placeholder=' ...')}" for mistake in mistakes)
    error = SpecError(first)
    for other in others:
        error.add_note(other)
    return error


def _place(path: _PATH, data: object) -> str:
    """Return the place of a mistake: its path in the data, and the name of the last room, piece or opening on this path."""
    names = []
    for i, part in enumerate(path):
        thing = _at(data, path[: i + 1])
        if isinstance(part, int) and isinstance(thing, dict) and i and path[i - 1] in _THINGS:
            names = [_name(str(path[i - 1]), thing)]
    text = _path(path) + "".join(f" ({name})" for name in names if name)
    return f"{text}: " if text else ""


_THINGS = {"rooms": "room", "furniture": "furniture", "openings": "opening", "windows": "window of"}


def _name(collection: str, thing: dict[str, object]) -> str:
    rooms = thing.get("rooms")
    if collection == "openings":
        return f"opening {' - '.join(_shown(room) for room in rooms)}" if isinstance(rooms, list) and len(rooms) == 2 else ""
    identifier = thing.get("room" if collection == "windows" else "id")
    return f"{_THINGS[collection]} {_shown(identifier)}" if isinstance(identifier, str) else ""


def _path(path: _PATH) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).lstrip(".")


def _at(data: Any, path: _PATH) -> Any:
    for part in path:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _node(path: _PATH, schema: dict[str, Any]) -> dict[str, Any]:
    """Return the part of the schema that belongs to a path; it is empty for a path that the schema does not have."""
    node = _resolved(schema, schema)
    for part in path:
        if isinstance(part, int):
            items = node.get("prefixItems")
            node = node.get("items", {}) if items is None else items[part] if part < len(items) else {}
        else:
            node = node.get("properties", {}).get(part, {})
        node = _resolved(node, schema)
    return node


def _resolved(node: dict[str, Any], schema: dict[str, Any]) -> dict[str, Any]:
    """Return a part of the schema with references followed; if it allows a value or null, return the part for the value."""
    if "anyOf" in node:
        chosen = next(choice for choice in node["anyOf"] if choice.get("type") != "null")
        node = {**chosen, "description": node.get("description", "")}
    if "$ref" in node:
        node = schema["$defs"][node["$ref"].rpartition("/")[2]]
    return node


def _described(node: dict[str, Any], schema: dict[str, Any]) -> str:
    """Describe in words which values a part of the schema allows."""
    node = _resolved(node, schema)
    if "enum" in node:
        return ", ".join(node["enum"])
    if "const" in node:
        return repr(node["const"])
    match node.get("type"):
        case "number" | "integer":
            return _number(node)
        case "string":
            return _IDENTIFIER if "pattern" in node else f"text of at most {node.get('maxLength', 0)} characters"
        case "array":
            return _array(node, schema)
        case "object":
            return f"an object with {', '.join(node.get('required') or node['properties'])}"
    return "nothing here"


def _number(node: dict[str, Any]) -> str:
    unit = _UNIT.search(node.get("description", ""))
    end = f" {unit[0]}" if unit else ""
    if node["type"] == "integer":
        return f"a whole number from {node['minimum']} to {node['exclusiveMaximum'] - 1}{end}"
    if "minimum" in node:
        return f"a number from {node['minimum']:g} to {node['maximum']:g}{end}"
    return f"a number above {node['exclusiveMinimum']:g} and at most {node['maximum']:g}{end}"


def _array(node: dict[str, Any], schema: dict[str, Any]) -> str:
    low, high = node.get("minItems", 0), node.get("maxItems")
    if "prefixItems" in node:
        return f"a list of {low}, each {_described(node['prefixItems'][0], schema)}"
    count = f"{low} to {high}" if low else f"at most {high}"
    return f"a list of {count}, each {_described(node['items'], schema)}"


def _shown(value: object) -> str:
    """Return a value from a file as a short text of one line."""
    match value:
        case None:
            return "null"
        case bool():
            return str(value).lower()
        case float() if not math.isfinite(value):
            return "not a number" if math.isnan(value) else "infinite"
        case list() | tuple():
            return f"a list of {len(value)}"
        case dict():
            return "an object"
        case str():
            return repr(value if len(value) <= 40 else value[:40] + "...")
    return str(value)[:40]
