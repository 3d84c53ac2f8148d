"""Finds what an older daemon does not know: it would ignore a field, and answer another question."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from collided.errors import Unimplemented
from collided.v1 import added_in_pb2, local_pb2
from collided.v1 import collision_service_pb2 as api


class Features:
    """Holds what the protocol has gained since release 0.1.0 (added_in.proto) and a daemon lacks; usually that is nothing."""

    def __init__(self, info: api.GetServerInfoResponse, address: str) -> None:
        self._daemon = f"the daemon at {address} is {info.version or 'of an unknown version'}"
        known = set(info.features)
        self._missing = {name: release for name, release in additions().items() if name not in known}

    def check(self, request: Any, path: str = "") -> None:
        """Raises Unimplemented, naming field, release and daemon, if the daemon would ignore something of a message. path: of the
        message."""
        if self._missing:
            for field, name in _contents(request, path):
                self._require(name, field)

    def lack(self, name: str) -> bool:
        """Returns True if the daemon does not know a field, an enum value or a method. name: its full name."""
        return name in self._missing

    def check_method(self, method: str) -> None:
        """The same of a method of CollisionService."""
        if self._missing:
            self._require(f"collided.v1.CollisionService.{method}", method)

    def _require(self, name: str, what: str) -> None:
        if name in self._missing:
            raise Unimplemented(f"{what} needs a daemon of release {self._missing[name]} or later; {self._daemon}", field=what)


def _contents(message: Any, path: str) -> Iterator[tuple[str, str]]:
    """Paths and full names of the fields and enum values that a message has, at all levels."""
    for field, value in message.ListFields():
        at = f"{path}.{field.name}" if path else field.name
        yield at, field.full_name
        if field.message_type is None and field.enum_type is None:
            continue
        is_repeated = _is_repeated(field)
        for i, each in enumerate(value if is_repeated else (value,)):
            place = f"{at}[{i}]" if is_repeated else at
            if field.message_type is not None:
                yield from _contents(each, place)
            elif known := field.enum_type.values_by_number.get(each):
                yield f"{place} = {known.name}", f"{field.enum_type.full_name.rpartition('.')[0]}.{known.name}"


def _is_repeated(field: Any) -> bool:
    if hasattr(field, "is_repeated"):  # labels are deprecated in protobuf 6 and later
        return field.is_repeated
    return field.label == field.LABEL_REPEATED


@lru_cache(1)
def additions() -> dict[str, str]:
    """Full names of all that names the release which brought it, with that release."""
    found: dict[str, str] = {}
    left, seen = [local_pb2.DESCRIPTOR], set()
    while left:
        file = left.pop()
        if file.name in seen:
            continue
        seen.add(file.name)
        left += file.dependencies
        _add_types(file.message_types_by_name.values(), file.enum_types_by_name.values(), found)
        for service in file.services_by_name.values():
            _add(service.methods, added_in_pb2.method_added_in, found)
    return found


def _add_types(messages: Any, enums: Any, found: dict[str, str]) -> None:
    for enum in enums:
        scope = enum.full_name.rpartition(".")[0]
        _add(enum.values, added_in_pb2.value_added_in, found, scope)
    for message in messages:
        _add(message.fields, added_in_pb2.field_added_in, found)
        _add_types(message.nested_types, message.enum_types, found)


def _add(elements: Any, option: Any, found: dict[str, str], scope: str = "") -> None:
    for element in elements:
        if release := element.GetOptions().Extensions[option]:
            found[f"{scope}.{element.name}" if scope else element.full_name] = release
