#!/usr/bin/env python3
"""Tests states of pairs, vertices in solids and signed distances, over every transport and in this process.

usage: solids_test.py DAEMON COLLIDECTL REPOSITORY; COLLIDED_LIBRARY in the environment adds the engine in this process
"""

import os
import unittest

from support import TRANSPORTS, Case, assert_same, main, np

import collided
from collided import PairState
from collided.connection.client import full_spec
from collided.contacts.checks import check_part
from collided.contacts.columns import Part
from collided.contacts.pairs import read_pairs
from collided.layout import Layout
from collided.v1 import contact_pb2, frame_pb2

SERVERS = [{"transport": name} for name in TRANSPORTS] + [{"server": "local"}] * ("COLLIDED_LIBRARY" in os.environ)
NONE = 2**32 - 1
# Vertex i is at (i & 1, i >> 1 & 1, i >> 2); the triangles' normals point outside.
SIDES = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
CUBE = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], float)
ROOM, INNER = 4 * CUBE, CUBE + [1.25, 1.5, 0]


def box(vertices, **options):
    return collided.Mesh(vertices, SIDES, **{"solid": True, "self_contacts": False, **options})


def boxes(z, **options):
    """A room, and a smaller box whose lower side is at height z."""
    return {"room": box(ROOM), "box": box(INNER + [0, 0, z], **options)}


def pairs_message(rows):
    """rows: two meshes, state, vertices of both inside, the deepest, its depth."""
    table = np.array(rows, float).reshape(-1, 7)
    return contact_pb2.MeshPairs(meshes=table[:, :2].astype("<u4").tobytes(), states=table[:, 2].astype("u1").tobytes(),
                                 inside=table[:, 3:5].astype("<u4").tobytes(), deepest=table[:, 5].astype("<u4").tobytes(),
                                 depths=table[:, 6].astype("<f8").tobytes())


class Answers(unittest.TestCase):
    layout = Layout.of({"room": box(ROOM), "box": box(INNER), "sheet": collided.Mesh(CUBE[:3], [[0, 1, 2]])})

    def read(self, *messages, last=None, are_asked=True):
        return read_pairs(messages, frame_pb2.FrameDone(pairs=last), self.layout, are_asked)

    def test_pairs_are_joined_from_all_messages(self):
        pairs = self.read(pairs_message([[0, 1, 4, 0, 8, 9, 1.5]]), last=pairs_message([[0, 2, 1, 0, 0, NONE, 0], [1, 2, 2, 0, 1, 16, 0.25]]))
        self.assertEqual(list(pairs), [("room", "box", PairState.SECOND_INSIDE, (0, 8), 9, 1.5), ("room", "sheet", PairState.TOUCHING, (0, 0), None, 0),
                                       ("box", "sheet", PairState.OVERLAPPING, (0, 1), 16, 0.25)])
        self.assertEqual((pairs.meshes.tolist(), pairs.states.tolist()), ([[0, 1], [0, 2], [1, 2]], [4, 1, 2]))
        self.assertEqual(pairs.between("sheet", 0), pairs[1])
        self.assertEqual(repr(pairs), "<MeshPairs: 'box' inside 'room', 1.5 deep; 'room' and 'sheet' touch; "
                                      "'box' and 'sheet' overlap, 0 and 1 vertices inside, 0.25 deep>")

    def test_none_are_told_only_where_they_were_asked_for(self):
        self.assertEqual((len(self.read()), repr(self.read())), (0, "<MeshPairs: none>"))
        self.assertIsNone(self.read().between("room", "box"))
        self.assertIsNone(self.read(are_asked=False))

    def test_answers_that_cannot_be_are_refused_by_name(self):
        good = [0, 1, 2, 1, 0, 3, 0.5]
        for why, *rows in (("pairs.meshes names mesh 3", [0, 3, *good[2:]]), ("pairs.meshes does not ascend", [1, 0, *good[2:]]),
                           ("pairs.meshes does not ascend", good, good), ("pairs.states", [0, 1, 0, *good[3:]]),
                           ("pairs.states", [0, 1, 5, *good[3:]]), ("pairs.inside", [0, 1, 2, 9, 0, 3, 0.5]),
                           ("pairs.deepest", [0, 1, 2, 0, 0, 3, 0]), ("pairs.deepest", [0, 1, 2, 1, 0, NONE, 0.5]),
                           ("pairs.deepest", [0, 1, 2, 1, 0, 19, 0.5]), ("pairs.depths", [*good[:6], -1]),
                           ("pairs.depths", [*good[:6], np.nan]), ("pairs.depths", [*good[:6], np.inf])):
            with self.subTest(why), self.assertRaisesRegex(collided.DataLoss, why):
                self.read(pairs_message(rows))
        for name, width in (("meshes", 8), ("inside", 8), ("deepest", 4), ("depths", 8)):
            message = pairs_message([good])
            setattr(message, name, bytes(width - 1))
            with self.assertRaisesRegex(collided.DataLoss, f"pairs.{name} has {width - 1} bytes for 1 pairs; it needs {width}"):
                self.read(message)
        with self.assertRaisesRegex(collided.DataLoss, "pairs has 1 pairs, and the frame did not ask for them"):
            self.read(pairs_message([good]), are_asked=False)

    def test_distances_that_cannot_be_are_refused(self):
        for kind, why, distance, sign in ((5, "not below 0", 0.0, None), (5, "not below 0", np.nan, None), (1, "not 0 or more", -1.0, None),
                                          (1, "signed_distances", 0.5, 0.25)):
            arrays = {"distance": np.array([distance])} | ({} if sign is None else {"signed_distances": np.array([sign])})
            with self.subTest(why), self.assertRaisesRegex(collided.DataLoss, why):
                check_part(Part(kind, 1, arrays), self.layout)
        for sign in (0.5, -0.5, np.nan):
            check_part(Part(1, 1, {"distance": np.array([0.5]), "signed_distances": np.array([sign])}), self.layout)


class Options(unittest.TestCase):
    def fields(self, **options):
        """Whether a scene asks for the states of pairs."""
        spec = full_spec(Layout.of(boxes(0) if options.pop("solids", True) else {"box": box(INNER, solid=False)}), collided.SceneOptions(**options))
        return contact_pb2.CONTACT_FIELD_PAIR_STATES in spec.fields

    def test_states_are_asked_for_where_there_are_solids_and_frames_that_can_tell(self):
        self.assertEqual((self.fields(mode="dcd"), self.fields(mode="dcd_and_ccd"), self.fields(mode="ccd")), (True, True, False))
        self.assertFalse(self.fields(mode="dcd", accuracy="candidates"))
        self.assertFalse(self.fields(mode="dcd", position_format="q16", quantization_box=collided.Box((-1, -1, -1), (5, 5, 5))))
        self.assertFalse(self.fields(mode="dcd", solids=False))
        self.assertFalse(self.fields(mode="dcd", fields=["elements"]))
        self.assertTrue(self.fields(mode="dcd", fields=["elements", "pair_states"]))

    def test_a_mesh_says_that_it_is_a_solid(self):
        self.assertEqual(repr(box(CUBE, name="a")), "<Mesh 'a': 8 vertices, 12 triangles, deformable, solid>")
        self.assertEqual([box(CUBE, solid=solid).spec().solid for solid in (True, np.True_, False)], [True, True, False])
        with self.assertRaises(collided.InvalidArgument) as caught:
            box(CUBE, solid="yes")
        self.assertEqual(caught.exception.field, "solid")


class EndToEnd(Case):
    options = ("--max-scenes-per-client", "200")  # sessions stay open until their test ends

    def each_way(self, meshes, **options):
        """The first frame of these meshes, over every transport and from the engine in this process."""
        frames = []
        for server in SERVERS:
            with self.subTest(**server):
                frames.append(self.session(meshes, **{"mode": "dcd", **options}, **server).step())
                assert_same(self, frames[-1], frames[0])
                self.assertEqual(list(frames[-1].pairs), list(frames[0].pairs))
        return frames[0]

    def test_states_of_two_boxes(self):
        for z, state, inside, depth in ((4.5, None, 0, 0), (4, PairState.TOUCHING, 0, 0), (3.5, PairState.OVERLAPPING, 4, 0.5),
                                        (1.5, PairState.SECOND_INSIDE, 8, 1.5)):
            for accuracy in ("fast", "certified", "exact"):
                contacts = self.each_way(boxes(z), accuracy=accuracy, kinds=["vs"])
                row = contacts.pairs.between("box", "room")
                if state is None:
                    self.assertEqual((len(contacts.pairs), row), (0, None))
                    continue
                self.assertEqual((row.first, row.second, row.state, row.inside), ("room", "box", state, (0, inside)))
                self.assertAlmostEqual(row.depth, depth, delta=1e-9)
                self.assertEqual((len(contacts), len(contacts.vs), contacts.metrics.counts.contacts_vertex_solid), (inside,) * 3)
                if inside:
                    self.assertEqual(contacts.vs.distance.min(), -row.depth)
                    self.assertEqual(contacts.vs.elements[np.argmin(contacts.vs.distance), 0], row.deepest)

    def test_vertices_inside_have_the_way_out(self):
        contacts = self.each_way(boxes(2.5), accuracy="exact", kinds=["vt", "ee", "vs"], thickness=0.75)
        deep = contacts.vs
        self.assertEqual(repr(deep), "<Contacts of frame 1: 8 vertex-solid>")
        self.assertEqual((deep.elements[:, 0].tolist(), deep.meshes.tolist()), (list(range(8, 16)), [[1, 0]] * 8))
        np.testing.assert_allclose(deep.distance, [-1.25, -1.5, -1.25, -1.5] + [-0.5] * 4, atol=1e-12)
        np.testing.assert_allclose(deep.normals[4:], [[0, 0, 1]] * 4, atol=1e-6)
        first, second = deep.points
        np.testing.assert_allclose(first, contacts.answer.ends[8:], atol=0)
        np.testing.assert_allclose(second - first, -deep.distance[:, None] * deep.normals, atol=1e-6)
        self.assertEqual(deep.stencils[:, 0].tolist(), deep.elements[:, 0].tolist())
        self.assertFalse(deep.has_column("toi"))

    def test_signs_of_distances(self):
        inside = self.each_way(boxes(2.5), accuracy="exact", thickness=0.75)
        self.assertGreater(len(inside.vt), 0)
        np.testing.assert_array_equal(inside.signed_distances, -inside.distance)
        first, second = inside.points
        np.testing.assert_allclose(first - second, inside.signed_distances[:, None] * inside.normals, atol=1e-6)
        outside = self.each_way(boxes(4.5), accuracy="exact", thickness=0.75)
        np.testing.assert_array_equal(outside.signed_distances, outside.distance)
        self.assertGreater(len(outside.vt), 0)
        through = self.each_way(boxes(3.5), accuracy="exact", thickness=0.6).between("room", "box").vt
        self.assertGreater(len(through), 0)  # of the box, and triangles that its edges go through
        self.assertTrue(np.isnan(through.signed_distances).all())

    def test_a_mesh_and_itself_have_no_sign(self):
        alone = self.each_way({"box": box(CUBE, self_contacts=True)}, thickness=0.75)
        self.assertGreater(len(alone), 0)
        self.assertTrue(np.isnan(alone.signed_distances).all())

    def test_a_sheet_is_no_solid(self):
        sheet = {"room": box(ROOM), "sheet": collided.Mesh(CUBE[:3] + [1, 1, 2], [[0, 1, 2]]), "other": collided.Mesh(CUBE[:3] + [1, 1, 2.1], [[0, 1, 2]])}
        contacts = self.each_way(sheet, thickness=0.25, kinds=["vt", "ee", "vs"])
        self.assertEqual([(row.first, row.second, row.state) for row in contacts.pairs],
                         [("room", name, PairState.SECOND_INSIDE) for name in ("sheet", "other")])
        sheets = contacts.between("sheet", "other")
        self.assertGreater(len(sheets), 0)
        self.assertTrue(np.isnan(sheets.signed_distances).all())

    def test_frames_that_do_not_tell(self):
        session = self.session(boxes(3.5), mode="dcd_and_ccd")
        moving = session.step({"box": INNER + [0, 0, 3]})
        self.refused(collided.FailedPrecondition, "frame 1 has no states of pairs", lambda: moving.pairs)
        self.assertEqual(session.step(mode="dcd").pairs[0].state, PairState.OVERLAPPING)
        any_hit = session.step(mode="dcd", report="any_hit")
        self.refused(collided.FailedPrecondition, "no states of pairs", lambda: any_hit.pairs)
        self.assertTrue(any_hit.any_contact)

    def test_what_is_no_solid_is_refused(self):
        def make(mesh, **options):
            return self.session({"box": mesh}, **{"mode": "dcd", **options})

        refusal = self.refused(collided.InvalidArgument, "edge", make, collided.Mesh(CUBE, SIDES[1:], solid=True))
        self.assertEqual(refusal.field, "spec.meshes[0].solid")
        for field, options in (("spec.kinds[0]", {"kinds": ["vs"]}), ("spec.fields[1]", {"fields": ["elements", "pair_states"]})):
            self.assertEqual(self.refused(collided.InvalidArgument, "solid", make, box(CUBE, solid=False), **options).field, field)
        q16 = {"position_format": "q16", "quantization_box": collided.Box((-1, -1, -1), (5, 5, 5))}
        self.assertEqual(self.refused(collided.InvalidArgument, "solid", make, box(CUBE), **q16).field, "spec.meshes[0].solid")

    def test_a_solid_that_is_inside_out_is_refused_in_its_first_frame(self):
        session = self.session({"box": collided.Mesh(CUBE, np.array(SIDES)[:, ::-1], solid=True)}, mode="dcd")
        self.refused(collided.InvalidArgument, "inside out", session.step)


if __name__ == "__main__":
    main()
