"""Reads the byte `features` of a contact. It says where the closest points are, and whether other contacts are the same or nearer.

The closest points are p, of the first feature, and q, of the second. Ties go to the feature of the lowest dimension."""

from __future__ import annotations

import enum

import numpy as np


class Feature(enum.IntFlag):
    """Lists the masks of the byte that say what covers a contact. Test bits, for more may be added.

    NEARER_AT_FIRST: the first surface comes clearly nearer beside p.
    NEARER_AT_SECOND: the second surface comes clearly nearer beside q.
    SAME_AS_BEFORE: an earlier contact is between the same two features; vertex-triangle contacts come before edge pairs.

    A barrier potential needs each pair of a vertex and a nearest place of a surface once:

        vt = contacts.vt
        pairs = vt[(vt.features & (Feature.NEARER_AT_SECOND | Feature.SAME_AS_BEFORE)) == 0]
    """

    NEARER_AT_FIRST = 16
    NEARER_AT_SECOND = 32
    SAME_AS_BEFORE = 64


class OnTriangle(enum.IntEnum):
    """Locates q on the triangle of a vertex and a triangle: within the face, on the side opposite to a corner, or on a corner. Corners
    are counted from 1, in the order of the stencil.

        above_faces = contacts.vt[OnTriangle.of(contacts.vt.features) == OnTriangle.FACE]
    """

    FACE = 0
    SIDE_1 = 1
    SIDE_2 = 2
    SIDE_3 = 3
    CORNER_1 = 4
    CORNER_2 = 5
    CORNER_3 = 6

    @staticmethod
    def of(features: np.ndarray) -> np.ndarray:
        """uint8[n]: returns the places of vertex-triangle contacts with these bytes."""
        return features & 7


class OnEdge(enum.IntEnum):
    """Locates a closest point of two edges: within its edge, or on its first or second end. The ends are in the order of the stencil.

        cross = contacts.ee[(OnEdge.of(contacts.ee.features) == OnEdge.INSIDE).all(axis=1)]
    """

    INSIDE = 0
    END_1 = 1
    END_2 = 2

    @staticmethod
    def of(features: np.ndarray) -> np.ndarray:
        """uint8[n][2]: returns the places of p and q of edge pairs with these bytes."""
        return np.stack([features & 3, features >> 2 & 3], axis=-1)
