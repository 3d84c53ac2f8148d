#!/usr/bin/env python3
"""Closest features, and contacts that others cover, over every transport and in this process."""

import os
import unittest

from support import TRANSPORTS, Case, assert_same, main, np

import collided
from collided import Feature, Flag, OnEdge, OnTriangle

SERVERS = [{"transport": name} for name in TRANSPORTS] + [{"server": "local"}] * ("COLLIDED_LIBRARY" in os.environ)
SQUARE = collided.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], motion="static")
ABOVE = 0.001


def spike(x, y, z=ABOVE):
    """A triangle on its tip, which is here."""
    return collided.Mesh([[x, y, z], [x - 0.2, y, 1], [x + 0.2, y + 0.1, 1]], [[0, 1, 2]])


class Bytes(unittest.TestCase):
    def test_places_are_read_from_their_bits(self):
        self.assertEqual(OnTriangle.of(np.array([0, 33, 66, 19, 4, 5, 127], "u1")).tolist(),
                         [OnTriangle.FACE, OnTriangle.SIDE_1, OnTriangle.SIDE_2, OnTriangle.SIDE_3, OnTriangle.CORNER_1,
                          OnTriangle.CORNER_2, 7])
        self.assertEqual(OnEdge.of(np.array([16, 9, 6], "u1")).tolist(),
                         [[OnEdge.INSIDE] * 2, [OnEdge.END_1, OnEdge.END_2], [OnEdge.END_2, OnEdge.END_1]])
        self.assertEqual(sum(Feature), 16 + 32 + 64)


class EndToEnd(Case):
    def each_way(self, meshes, **options):
        """The first frame of these meshes, over every transport and from the engine in this process."""
        frames = []
        for server in SERVERS:
            with self.subTest(**server):
                frames.append(self.session(meshes, mode="dcd", thickness=0.02, position_format="f64", **options, **server).step())
                assert_same(self, frames[-1], frames[0])
        return frames[0]

    def test_a_vertex_above_a_diagonal_has_one_kept_contact(self):
        for accuracy in ("fast", "guarded", "certified", "exact"):
            contacts = self.each_way({"floor": SQUARE, "spike": spike(0.5, 0.5)}, accuracy=accuracy)
            self.assertEqual(contacts.vt.elements.tolist(), [[4, 0], [4, 1]])
            self.assertEqual(OnTriangle.of(contacts.vt.features).tolist(), [OnTriangle.SIDE_2, OnTriangle.SIDE_3])
            tips = contacts.ee[contacts.ee.distance < 2 * ABOVE]  # of both edges at the tip, with the diagonal
            self.assertEqual(len(tips), 2)
            self.assertEqual(OnEdge.of(tips.features).tolist(), [[OnEdge.INSIDE, OnEdge.END_1]] * 2)
            self.assertEqual(contacts.kept.elements.tolist(), [[4, 0]])
            np.testing.assert_allclose(contacts.kept.normals, [[0, 0, 1]], atol=1e-6)
            self.assertEqual((contacts.features & Feature.SAME_AS_BEFORE != 0).tolist(), [False, True, True, True])

    def test_a_vertex_above_a_face_or_a_corner(self):
        # Over a corner, the floor's own vertex is as near to the tip.
        at_corner = [OnTriangle.CORNER_1, OnTriangle.CORNER_3, OnTriangle.CORNER_2]
        for (x, y), places in (((0.75, 0.25), [OnTriangle.FACE]), ((1, 1), at_corner)):
            contacts = self.each_way({"floor": SQUARE, "spike": spike(x, y)}).vt
            self.assertEqual(OnTriangle.of(contacts.features).tolist(), places)
            self.assertEqual(len(contacts.kept), 1)

    def test_what_is_nearer_beside_it_covers_a_contact(self):
        """A tip above a slope: the square's lower side is near it, but the face is nearer."""
        tilted = collided.Mesh(SQUARE.vertices @ [[1, 0, 0], [0, 1, 0.5], [0, 0, 1]], SQUARE.triangles)
        contacts = self.each_way({"floor": tilted, "spike": spike(0.5, 0.005, 0.01)})
        self.assertEqual((contacts.kinds.tolist(), contacts.kept.kinds.tolist()), ([1, 2, 2], [1]))
        self.assertEqual(OnTriangle.of(contacts.vt.features).tolist(), [OnTriangle.FACE])
        self.assertEqual((contacts.ee.features & Feature.NEARER_AT_FIRST).tolist(), [16, 16])
        self.assertLess(contacts.vt.distance.max(), contacts.ee.distance.min())

    def test_only_discrete_frames_have_them(self):
        meshes = {"floor": SQUARE, "spike": spike(0.5, 0.5)}
        session = self.session(meshes, mode="dcd_and_ccd", thickness=0.02)
        down = {"spike": spike(0.5, 0.5).vertices - [0, 0, 0.01]}
        self.assertFalse(session.step(down, trial=True).has_column("features"))
        self.assertTrue(session.step(down, mode="dcd").has_column("features"))
        for options in ({"fields": ["elements", "flags"]}, {"accuracy": "candidates"}):
            contacts = self.session(meshes, mode="dcd", thickness=0.02, **options).step()
            self.assertFalse(contacts.has_column("features"))
            if "accuracy" not in options:
                self.assertEqual(len(contacts.kept), len(contacts))

    def test_scenes_of_one_kind_cover_nothing(self):
        contacts = self.each_way({"floor": SQUARE, "spike": spike(0.5, 0.5)}, kinds=["vt"])
        self.assertFalse(contacts.has_flag(Flag.COVERED).any())
        self.assertEqual((contacts.features & Feature.SAME_AS_BEFORE != 0).tolist(), [False, True])


if __name__ == "__main__":
    main()
