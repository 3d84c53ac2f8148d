"""Words that callers pass: text, and values of the protocol's enumerations by name."""

from __future__ import annotations

import numbers
from typing import Any

from collided.errors import InvalidArgument


def choice(enum: Any, prefix: str, value: str | int | None, argument: str) -> Any:
    """The value of `enum` that a word such as "certified" names; 0 for None. Numbers of the protocol are kept."""
    if value is None:
        return 0
    words = _words(enum, prefix)
    if isinstance(value, str):
        known = words.get(value.lower().replace("-", "_"))
        if known:
            return known
    elif not isinstance(value, bool) and isinstance(value, numbers.Integral) and value in words.values():
        return int(value)
    raise InvalidArgument(f"{argument} is {value!r}; it must be one of {usable(enum, prefix)}", field=argument)


def usable(enum: Any, prefix: str) -> str:
    """All words that name a value."""
    return ", ".join(word for word, number in _words(enum, prefix).items() if number)


def _words(enum: Any, prefix: str) -> dict[str, int]:
    return {name.removeprefix(prefix).lower(): number for name, number in enum.items()}


def check_flag(value: Any, argument: str) -> bool:
    """True or False, also numpy's."""
    if not isinstance(value, (bool, int)) and type(value).__name__ not in ("bool_", "bool") or value not in (0, 1):
        raise InvalidArgument(f"{argument} is {value!r}; it must be True or False", field=argument)
    return bool(value)


def check_text(value: Any, argument: str) -> None:
    """Whether it is text that can be sent."""
    if not isinstance(value, str) or any("\ud800" <= character <= "\udfff" for character in value):
        raise InvalidArgument(f"{argument} is {value!r}; it must be text", field=argument)


def word(enum: Any, prefix: str, number: int) -> str:
    """The word that names a value."""
    return enum.Name(number).removeprefix(prefix).lower()
