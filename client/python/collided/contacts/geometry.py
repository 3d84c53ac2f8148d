"""What follows from contacts' columns: their meshes, their points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from collided.errors import FailedPrecondition
from collided.v1 import contact_pb2

if TYPE_CHECKING:
    from collided.contacts.contacts import Contacts


def meshes_of(contacts: Contacts) -> np.ndarray:
    """Mesh indices of both features, int64[n][2]."""
    layout, kinds = contacts.answer.layout, contacts.kinds
    out = np.empty((len(contacts), 2), np.int64)
    pairs, crossings = (kinds == contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE), _are_crossings(contacts)
    if pairs.any():
        out[pairs] = _owner(layout.element_offsets, contacts.elements[pairs])
    if crossings.any():
        elements = contacts.elements[crossings]
        out[crossings, 0] = _owner(layout.edge_offsets, elements[:, 0])
        out[crossings, 1] = _owner(layout.element_offsets, elements[:, 1])
    others = ~(pairs | crossings)
    if others.any():
        stencils = contacts.stencils[others]
        second = np.where(kinds[others] == contact_pb2.CONTACT_KIND_EDGE_EDGE, stencils[:, 2], stencils[:, 1])
        out[others] = _owner(layout.vertex_offsets, np.stack([stencils[:, 0], second], axis=1))
    return out


def _are_crossings(contacts: Contacts) -> np.ndarray:
    return contacts.kinds == contact_pb2.CONTACT_KIND_EDGE_TRIANGLE


def _owner(offsets: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Which range each id is in; empty ranges, of meshes that were removed, own none."""
    return np.searchsorted(offsets, ids, side="right") - 1


def closest_points(contacts: Contacts) -> tuple[np.ndarray, np.ndarray]:
    """The formula of proto/CONVENTIONS.md, "Points"."""
    answer = contacts.answer
    if answer.way is None:
        raise FailedPrecondition("a frame that is watched, or of a DeviceSession, has no positions that points could be computed from")
    pairs, crossings = contacts.kinds == contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE, _are_crossings(contacts)
    if pairs.all():
        return np.full((len(contacts), 3), np.nan), np.full((len(contacts), 3), np.nan)
    stencils = np.zeros((len(contacts), 4), np.int64)
    others = ~(pairs | crossings)
    if others.any():
        stencils[others] = contacts.stencils[others]
    if crossings.any():
        stencils[crossings, 1:] = answer.layout.corners[contacts.elements[crossings, 1]]
    x = answer.ends[stencils]
    if answer.has_motion:
        t = contacts.toi[:, None, None]
        x = (1 - t) * answer.starts[stencils] + t * x
    w0, w1 = contacts.weights[:, 0, None], contacts.weights[:, 1, None]
    edges = (contacts.kinds == contact_pb2.CONTACT_KIND_EDGE_EDGE)[:, None]
    first = np.where(edges, (1 - w0) * x[:, 0] + w0 * x[:, 1], x[:, 0])
    second = np.where(edges, (1 - w1) * x[:, 2] + w1 * x[:, 3],
                      (1 - w0 - w1) * x[:, 1] + w0 * x[:, 2] + w1 * x[:, 3])
    first[pairs] = np.nan
    first[crossings] = second[crossings]
    return first, second
