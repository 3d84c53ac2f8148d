#!/usr/bin/env python3
"""What limits the way of a frame that advances: how it is asked for, read and refused, and that it is so.

tests/client/hostile sends more of the answers that cannot be.

usage: limits_test.py DAEMON COLLIDECTL REPOSITORY; COLLIDED_LIBRARY in the environment adds the engine in this process
"""

import os
import unittest

from distances import edge_edge, vertex_triangle
from support import FLOOR, ONE, TIP, TRANSPORTS, Case, assert_same, body_turned, lowered, main, meshes, np, turning
from waves import grid, wave

import collided
from collided.columns import COLUMNS
from collided.contacts.answer import Answer
from collided.contacts.columns import read_limits
from collided.frames.options import frame_head
from collided.layout import Layout
from collided.v1 import contact_pb2, frame_pb2

VT, EE, TT = (contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE, contact_pb2.CONTACT_KIND_EDGE_EDGE, contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE)


def chunk(kind=VT, count=1, first=3, **changes):
    """Contacts whose first feature counts up from `first`."""
    ids = np.arange(first, first + count)
    pairs = np.stack([ids, 0 * ids], 1) if kind == VT else np.stack([0 * ids, ids], 1)
    arrays = {"elements": pairs.astype("<u4"), "stencils": np.tile([[3, 0, 1, 2]], (count, 1)).astype("<u4"),
              "toi": np.full(count, 0.5), "distance": np.full(count, 0.25), "weights": np.full((count, 2), 0.25),
              "normals": np.tile([[0, 0, 1]], (count, 1)).astype("<f4"), "flags": np.ones(count, "u1")}
    return contact_pb2.ContactChunk(**{"kind": kind, "count": count, **{name: array.tobytes() for name, array in arrays.items()}, **changes})


def contacts(chunks, are_asked=True):
    done = frame_pb2.FrameDone(earliest_toi=1, advanced=0.5, way=0.5)
    layout = Layout.of(meshes())
    return collided.Contacts.of_parts(Answer(1, 1, done, layout, None, True, limits=read_limits(chunks, are_asked)), [])


class Options(unittest.TestCase):
    def test_a_frame_says_that_it_wants_them(self):
        for value, expected in ((True, True), (np.True_, True), (False, False), (None, False)):
            self.assertEqual(frame_head({"advance": "per_vertex", "limits": value}).limits, expected)
        for bad in (0.5, "yes", []):
            with self.assertRaises(collided.InvalidArgument) as caught:
                frame_head({"advance": True, "limits": bad})
            self.assertEqual(caught.exception.field, "limits")


class Answers(unittest.TestCase):
    def test_chunks_are_joined(self):
        limits = contacts([chunk(), chunk(count=2, first=4), chunk(EE, first=1)]).limits
        self.assertEqual(limits.kinds.tolist(), [1, 1, 1, 2])
        self.assertEqual(limits.elements.tolist(), [[3, 0], [4, 0], [5, 0], [0, 1]])
        self.assertEqual((limits.meshes[0].tolist(), limits.local_stencils[0].tolist()), ([1, 0], [0, 0, 1, 2]))
        self.assertEqual((len(limits.vt), len(limits.ee), len(limits.of_mesh("tip"))), (3, 1, 4))
        self.assertEqual(limits.records.dtype.names, ("kind", *(c.name for c in COLUMNS.values() if c.in_limits)))
        self.assertEqual(limits[limits.toi < 0.5].limits.elements.tolist(), limits.elements.tolist())

    def test_none_have_every_column(self):
        for limits in (contacts([]).limits, contacts([], are_asked=False).limits):
            self.assertEqual([getattr(limits, name).shape for name in COLUMNS], [(0, *column.shape) for column in COLUMNS.values()])

    def test_answers_that_cannot_be_are_refused_by_name(self):
        for why, *chunks in (("limits.kind is TRIANGLE_TRIANGLE", chunk(), chunk(TT)), ("limits.kind is 77", chunk(kind=77)),
                             ("limits.count is 0", chunk(count=0)),
                             ("limits.stencils names 6; the scene has 6 vertices", chunk(stencils=np.array([3, 0, 1, 6], "<u4").tobytes())),
                             ("limits.elements names 6; the scene has 6 vertices", chunk(first=6)),
                             ("limits.elements names 6; the scene has 6 edges at most", chunk(EE, first=6)),
                             ("limits.toi has a time", chunk(toi=np.array([1.5]).tobytes())),
                             ("limits.distance has a distance", chunk(distance=np.array([np.nan]).tobytes())),
                             *((f"limits.{name} has 0 bytes for 1 contacts; it needs {column.width}", chunk(), chunk(**{name: b""}))
                               for name, column in COLUMNS.items() if column.in_limits),
                             *((f"limits.{name} has {column.width - 1} bytes", chunk(**{name: bytes(column.width - 1)}))
                               for name, column in COLUMNS.items() if column.width > 1)):
            with self.subTest(why), self.assertRaisesRegex(collided.DataLoss, why):
                contacts(chunks)
        with self.assertRaisesRegex(collided.DataLoss, "limits has 2 chunks, and the frame did not ask for them"):
            contacts([chunk(), chunk()], are_asked=False)


GAP = 0.25
SERVERS = [{"transport": name} for name in TRANSPORTS] + [{"server": "local"}] * ("COLLIDED_LIBRARY" in os.environ)


class EndToEnd(Case):
    def each_way(self, what=None, **options):
        """Sessions of every transport, and of the engine in this process."""
        for server in SERVERS:
            with self.subTest(**server):
                yield self.session(what, mode="ccd", min_separation=GAP, **options, **server)

    def test_the_tip_is_limited_by_the_floor(self):
        for session in self.each_way(fields=["toi"]):
            gone = session.step(lowered(2), advance="per_vertex", limits=True)
            limits = gone.limits
            self.assertEqual((limits.elements.tolist(), limits.stencils.tolist()), ([[3, 0]], [[3, 0, 1, 2]]))
            self.assertEqual((limits.meshes.tolist(), limits.local_stencils.tolist()), ([[1, 0]], [[0, 0, 1, 2]]))
            self.assertEqual(limits.distance.tolist(), [GAP])
            np.testing.assert_allclose(limits.toi, [(1 - GAP) / 2], atol=1e-3)
            self.assertLessEqual(limits.toi[0], (1 - GAP) / 2)
            np.testing.assert_allclose(limits.weights, [[0.25, 0.25]], atol=1e-3)
            self.assertEqual(limits.normals.tolist(), [[0, 0, 1]])
            first, second = limits.points
            np.testing.assert_allclose([first[0], second[0]], [[1, 1, 1 - 2 * limits.toi[0]], [1, 1, 0]], atol=1e-6)
            self.assertEqual(gone[:0].limits.elements.tolist(), [[3, 0]])

    def test_there_are_none_where_nothing_blocks_and_where_nobody_asks(self):
        for session in self.each_way():
            self.assertEqual(len(session.step(lowered(0.5), advance="per_vertex", limits=True).limits), 0)
            blocked = session.step(lowered(2), advance="per_vertex", trial=True)
            self.assertEqual((blocked.advanced < 1, len(blocked.limits)), (True, 0))
            self.assertEqual(len(session.step(lowered(2), advance="per_vertex", limits=True, trial=True).limits), 1)

    def test_a_frame_that_does_not_advance_is_refused(self):
        for session in self.each_way():
            refusal = self.refused(collided.InvalidArgument, "limits", session.step, lowered(2), limits=True)
            self.assertTrue(refusal.field.endswith("limits"), refusal.field)
            self.assertEqual(len(session.step(lowered(2), advance=True, limits=True).limits), 1)

    def test_each_comes_to_its_distance_at_its_time(self):
        """By arithmetic of the test's own, at the positions to which that fraction of the whole way leads."""
        upper, lower = wave(0, 0.6, "<f8"), wave(2, 0, "<f8")
        made = {"lower": collided.Mesh(lower, grid(), motion="static"), "upper": (upper, grid())}
        for form, dtype in (("f32", "<f4"), ("f64", "<f8")):
            start, target = (np.concatenate([lower, there]).astype(dtype).astype("<f8") for there in (upper, wave(0.3, 0.05, "<f8")))
            found = []
            for server in SERVERS:
                with self.subTest(form=form, **server):
                    session = self.session(made, mode="ccd", min_separation=0.01, position_format=form, **server)
                    for advance in (True, "per_mesh", "per_vertex"):
                        gone = session.step({"upper": target[len(lower):]}, advance=advance, limits=True, trial=True)
                        found.append(gone.limits)
                        self.check(gone.limits, start, target)
                        if advance is True:
                            self.assertTrue(0.99 < gone.advanced / gone.limits.toi.min() <= 1, gone.advanced)
                    self.assertEqual(found[-1].records.tobytes(), found[0].records.tobytes())
                    session.close()

    def check(self, limits, start, target):
        self.assertTrue(len(limits.vt) > 20 and len(limits.ee) > 20, limits)
        for found, distance_of in ((limits.vt, vertex_triangle), (limits.ee, edge_edge)):
            at = np.array([collided.move_along(start[stencil], target[stencil], toi)
                           for stencil, toi in zip(found.stencils, found.toi)])
            distances = distance_of(at)
            early = distances - found.distance
            self.assertTrue(-1e-14 < early.min() and early.max() < 1e-12, (early.min(), early.max()))
            first, second = found.points
            away = first - second
            np.testing.assert_allclose(np.linalg.norm(away, axis=1), distances, rtol=1e-6)
            np.testing.assert_allclose(found.normals, away / distances[:, None], atol=1e-4)


if __name__ == "__main__":
    main()
