"""Checks that guard everything computed from an answer: the daemon may be wrong, or another program may answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from collided.errors import DataLoss
from collided.kinds import KINDS
from collided.v1 import contact_pb2, frame_pb2

if TYPE_CHECKING:
    from collided.contacts.columns import Part
    from collided.layout import Layout

CONTACTS, LIMITS = "contacts", "limits"  # fields of a frame's answer that hold contacts
_LIMIT_NO_WAY = (contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE, contact_pb2.CONTACT_KIND_EDGE_TRIANGLE, contact_pb2.CONTACT_KIND_VERTEX_SOLID)
_MOST_BARE = 1 << 24  # contacts of a chunk without any array, whose number nothing else confirms


def check_chunk(chunk: contact_pb2.ContactChunk, field: str = CONTACTS) -> None:
    """Checks the kind and the count of a chunk of `field`. Raises DataLoss."""
    if chunk.kind not in KINDS:
        raise DataLoss(f"{field}.kind is {chunk.kind}, which this client does not know")
    if not chunk.count:
        raise DataLoss(f"{field}.count is 0; a chunk has 1 contact or more")


def check_limits(chunks: Sequence[contact_pb2.ContactChunk], are_asked: bool) -> None:
    """Checks that chunks of limits were asked for, and are of kinds that limit a way. Raises DataLoss."""
    if chunks and not are_asked:
        raise DataLoss(f"limits has {len(chunks)} chunks, and the frame did not ask for them")
    for chunk in chunks:
        if chunk.kind in _LIMIT_NO_WAY:
            name = KINDS[chunk.kind].name.upper()
            raise DataLoss(f"limits.kind is {name}; only a vertex and a triangle, or two edges, limit a way")


def check_done(done: frame_pb2.FrameDone) -> None:
    """Times and fractions of a frame's end. Raises DataLoss."""
    for name in ("earliest_toi", "advanced", "way"):
        value = getattr(done, name)
        if not 0 <= value <= 1:
            raise DataLoss(f"done.{name} is {value}; it must be in [0, 1]")


def check_total(done: frame_pb2.FrameDone, parts: list[Part]) -> None:
    """The number of contacts that came. Raises DataLoss."""
    came = sum(part.count for part in parts)
    if done.contact_count != came:
        raise DataLoss(f"done.contact_count is {done.contact_count}, and {came} contacts came")


def check_part(part: Part, layout: Layout, field: str = CONTACTS) -> None:
    """Checks times, distances and ids of contacts of `field`. Raises DataLoss."""
    arrays = part.arrays
    if not arrays and part.count > _MOST_BARE:
        raise DataLoss(f"{field}.count is {part.count} without any array; it must be at most {_MOST_BARE}")
    toi = arrays.get("toi")
    if toi is not None and not (toi.min() >= 0 and toi.max() <= 1):
        raise DataLoss(f"{field}.toi has a time that is not in [0, 1]")
    _check_distances(part, field)
    if (stencils := arrays.get("stencils")) is not None:
        _check_ids(f"{field}.stencils", stencils, int(layout.vertex_offsets[-1]), "vertices")
    if (elements := arrays.get("elements")) is not None:
        vertices, count = int(layout.vertex_offsets[-1]), int(layout.element_offsets[-1])
        vertex, edge, element = (vertices, "vertices"), (3 * count, "edges at most"), (count, "elements")
        both = {contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE: (vertex, element), contact_pb2.CONTACT_KIND_EDGE_EDGE: (edge, edge),
                contact_pb2.CONTACT_KIND_EDGE_TRIANGLE: (edge, element),
                contact_pb2.CONTACT_KIND_VERTEX_SOLID: (vertex, element)}.get(part.kind, (element, element))
        for ids, feature in zip(elements.T, both):
            _check_ids(f"{field}.elements", ids, *feature)


def _check_distances(part: Part, field: str) -> None:
    """Depths are below 0, all other distances 0 or more, and a sign changes nothing else."""
    distance, with_sign = part.arrays.get("distance"), part.arrays.get("signed_distances")
    if distance is not None and part.kind == contact_pb2.CONTACT_KIND_VERTEX_SOLID:
        if not distance.max() < 0:
            raise DataLoss(f"{field}.distance has a distance of a vertex in a solid that is not below 0")
    elif distance is not None and not distance.min() >= 0:
        raise DataLoss(f"{field}.distance has a distance that is not 0 or more")
    if distance is not None and with_sign is not None and not (np.isnan(with_sign) | (np.abs(with_sign) == distance)).all():
        raise DataLoss(f"{field}.signed_distances has a distance that is neither {field}.distance nor minus it")


def _check_ids(name: str, ids: np.ndarray, count: int, of_what: str) -> None:
    if (largest := int(ids.max())) >= count:
        raise DataLoss(f"{name} names {largest}; the scene has {count} {of_what}")
