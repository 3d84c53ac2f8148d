"""Contacts as tables: structured arrays, pandas."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from collided.columns import COLUMNS
from collided.kinds import KINDS

if TYPE_CHECKING:
    from collided.contacts.contacts import Contacts

_KIND_NAMES = np.array(["", *(kind.name for kind in KINDS.values())])


def records(contacts: Contacts) -> np.ndarray:
    """A structured array of `kind` and the columns that are there."""
    there = [column for column in COLUMNS.values() if contacts.has_column(column.name)]
    out = np.empty(len(contacts), [("kind", "u1"), *((c.name, c.dtype, c.shape) for c in there)])
    out["kind"] = contacts.kinds
    for column in there:
        out[column.name] = getattr(contacts, column.name)
    return out


def dataframe(contacts: Contacts) -> Any:
    """A row for each contact."""
    import pandas  # not needed for anything else

    table: dict[str, Any] = {"kind": _KIND_NAMES[contacts.kinds]}
    for name, column in COLUMNS.items():
        if contacts.has_column(name):
            values = getattr(contacts, name)
            table |= {part: values[:, i] for i, part in enumerate(column.parts)} if column.parts else {name: values}
    if contacts.has_column("stencils") or contacts.has_column("elements"):
        names = np.array([mesh.name if mesh else "" for mesh in contacts.answer.layout.meshes])
        for i, side in enumerate(("first_mesh", "second_mesh")):
            table[side] = names[contacts.meshes[:, i]]
    return pandas.DataFrame(table)
