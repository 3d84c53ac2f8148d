#!/usr/bin/env python3
"""Contacts as one structured view, against collidectl's and the conventions' words."""

import csv
import dataclasses
import os
import subprocess
import sys
import tempfile
import time

from support import COLLIDECTL, DAEMON, FLOOR, ONE, TIP, Case, assert_same, lowered, main, meshes, np

import collided
from collided import Flag
from collided.contacts.checks import check_limits, check_part
from collided.contacts.columns import Part
from collided.layout import Layout
from collided.v1 import contact_pb2

# CONVENTIONS.md, "A worked example".
SQUARE = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], float)
SLOPE = np.array([[3.5, 3, 3], [4.5, 3, -1], [4.5, 3.5, 3]])
TALL = np.array([[2, 1, 1], [2, 1, 4], [3, 1, 4]], float)
FALL = np.array([0, 0, -2])
# Two triangles with the corner 0, of which the second one goes through the first.
FOLDED = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [2, 1, -1], [2, 1.5, 2]])
WORKED = {"square": collided.Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]], motion="static"), "tip": (TALL, ONE), "slope": (SLOPE, ONE)}


class View(Case):
    def setUp(self):
        self.contacts = self.session(WORKED).step({"tip": TALL + FALL, "slope": SLOPE + FALL})

    def test_columns_are_those_of_the_conventions(self):
        contacts = self.contacts
        self.assertEqual(contacts.kinds.tolist(), [1, 2])
        self.assertEqual(contacts.elements.tolist(), [[4, 0], [3, 8]])
        self.assertEqual(contacts.stencils.tolist(), [[4, 0, 1, 2], [1, 2, 7, 8]])
        np.testing.assert_allclose(contacts.toi, [0.5, 0.5])
        np.testing.assert_allclose(contacts.weights, [[0.25, 0.25], [0.75, 0.5]], atol=1e-12)
        np.testing.assert_allclose(contacts.normals, [[0, 0, 1], [-0.970143, 0, -0.242536]], atol=1e-6)
        first, second = contacts.points
        np.testing.assert_allclose(first, [[2, 1, 0], [4, 3, 0]], atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(first - second, axis=1), contacts.distance, atol=1e-12)
        self.assertEqual((contacts.any_contact, contacts.advanced, contacts.skipped), (True, None, False))
        self.assertGreater(contacts.metrics.total_milliseconds, 0)

    def test_selections(self):
        contacts = self.contacts
        self.assertEqual((len(contacts.vt), len(contacts.ee), len(contacts.tt)), (1, 1, 0))
        self.assertEqual(contacts.ee.elements.tolist(), [[3, 8]])
        self.assertEqual(contacts.meshes.tolist(), [[1, 0], [0, 2]])
        self.assertEqual(contacts.of_mesh("tip").elements.tolist(), [[4, 0]])
        self.assertEqual(len(contacts.of_mesh(0)), 2)
        self.assertEqual(len(contacts.between("slope", "square")), 1)
        self.assertEqual(len(contacts.between("slope", "tip")), 0)
        self.assertEqual(len(contacts.between("square", "square")), 0)
        self.assertEqual(contacts.local_stencils.tolist(), [[0, 0, 1, 2], [1, 2, 0, 1]])
        self.assertEqual(contacts[contacts.has_flag(Flag.CERTIFIED)].vt.of_mesh("tip").elements.tolist(), [[4, 0]])
        self.assertEqual(len(contacts[contacts.has_flag(Flag.INITIAL)]), 0)
        self.assertEqual(contacts[::-1].kinds.tolist(), [2, 1])
        self.assertEqual(contacts[-1].points[0].shape, (1, 3))
        self.assertEqual(contacts.vt.earliest_toi, contacts.earliest_toi)
        self.refused(IndexError, "out of bounds", contacts.__getitem__, 2)
        self.refused(collided.InvalidArgument, "indexed", contacts.__getitem__, np.ones(5, bool))
        self.refused(collided.InvalidArgument, "'wall' is not in the scene", contacts.of_mesh, "wall")

    def test_records_and_text(self):
        records = self.contacts.records
        self.assertEqual(records.dtype.names, ("kind", "elements", "stencils", "toi", "distance", "weights", "normals", "flags"))
        self.assertEqual([row["kind"] for row in self.contacts], [1, 2])
        self.assertEqual(repr(self.contacts), "<Contacts of frame 1: 1 vertex-triangle, 1 edge-edge>")
        self.assertEqual(repr(self.contacts.tt), "<Contacts of frame 1: none>")

    def test_a_dataframe_where_pandas_is_there(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.assertRaises(ImportError, self.contacts.to_dataframe)
            return
        table = self.contacts.to_dataframe()
        self.assertEqual(table["kind"].tolist(), ["vertex_triangle", "edge_edge"])
        self.assertEqual(table["first_mesh"].tolist(), ["tip", "square"])
        self.assertEqual(table["v0"].tolist(), [4, 1])

    def test_frames_without_contacts_have_empty_columns(self):
        contacts = self.session().step({"tip": TIP})
        self.assertEqual((contacts.stencils.shape, contacts.weights.shape, contacts.toi.shape), ((0, 4), (0, 2), (0,)))
        self.assertEqual((contacts.points[0].shape, contacts.meshes.shape, len(contacts.of_mesh("tip"))), ((0, 3), (0, 2), 0))

    def test_columns_that_were_not_asked_for_say_so(self):
        contacts = self.session(fields=["elements", "toi"]).step({"tip": lowered(2)})
        self.assertEqual(contacts.elements.tolist(), [[3, 0]])
        for name in ("weights", "normals", "points", "meshes"):
            self.refused(collided.FailedPrecondition, "fields", getattr, contacts, name)
        self.assertEqual(contacts.records.dtype.names, ("kind", "elements", "toi"))

    def test_triangle_pairs_beside_other_kinds(self):
        pierced = lowered(1.25)
        contacts = self.session(mode="dcd", thickness=0.5, kinds=["vt", "ee", "tt"]).step({"tip": pierced})
        self.assertEqual(contacts.tt.elements.tolist(), [[0, 1]])
        self.assertEqual(contacts.tt.meshes.tolist(), [[0, 1]])
        self.assertTrue(np.isnan(contacts.tt.distance).all() and np.isnan(contacts.tt.points[0]).all())
        self.assertEqual(contacts.tt.stencils.tolist(), [[2**32 - 1] * 4])
        self.assertEqual(contacts.tt.local_stencils.tolist(), [[2**32 - 1] * 4])

    def test_an_edge_goes_through_a_neighbour(self):
        folded = collided.Mesh(FOLDED, [[0, 1, 2], [0, 3, 4]])
        contacts = self.session(folded, mode="dcd", accuracy="exact", kinds=["vt", "ee", "et"]).step()
        self.assertEqual(repr(contacts), "<Contacts of frame 1: 1 edge-triangle>")
        self.assertEqual((contacts.kinds.tolist(), contacts.et.elements.tolist()), ([4], [[5, 0]]))
        np.testing.assert_allclose(contacts.weights, [[1 / 2, 7 / 24]], atol=1e-12)
        for point in contacts.points:
            np.testing.assert_allclose(point, [[2, 7 / 6, 0]], atol=1e-12)
        self.assertEqual(contacts.flags.tolist(), [Flag.CERTIFIED])
        self.assertTrue(contacts.any_contact)
        self.assertEqual(contacts.metrics.counts.contacts_edge_triangle, 1)
        for column in ("stencils", "toi", "distance", "normals"):
            self.assertFalse(contacts.has_column(column), column)
        triangles = self.session(folded, mode="dcd", accuracy="exact", kinds=["tt"]).step()
        self.assertEqual(triangles.tt.elements.tolist(), [[0, 1]])
        for kind in ("et", "tt"):
            apart = self.session(dataclasses.replace(folded, exclude_rings=1), mode="dcd", accuracy="exact", kinds=[kind]).step()
            self.assertEqual((len(apart), apart.any_contact), (0, False))

    def test_crossings_of_two_meshes_beside_other_kinds(self):
        pierced = lowered(1.25)
        for tip_comes_first in (False, True):
            made = dict(sorted(meshes().items(), reverse=tip_comes_first))
            contacts = self.session(made, mode="dcd", thickness=0.5, kinds=["vt", "et"]).step({"tip": pierced})
            self.assertEqual(contacts.et.between("tip", "floor").elements.tolist(), contacts.et.elements.tolist())
            self.assertGreater(len(contacts.et), 0)
            self.assertGreater(len(contacts.vt), 0)
            tip, floor = list(made).index("tip"), list(made).index("floor")
            self.assertEqual({tuple(pair) for pair in contacts.et.meshes.tolist()}, {(tip, floor)})
            first, second = contacts.points
            self.assertTrue((first[contacts.kinds == 4] == second[contacts.kinds == 4]).all())
            np.testing.assert_allclose(second[contacts.kinds == 4][:, 2], FLOOR[0][2], atol=1e-6)
            self.assertTrue(np.isfinite(first).all())

    def test_where_there_are_no_crossings_they_are_refused(self):
        box = collided.Box((-9, -9, -9), (9, 9, 9))
        for options in ({"mode": "ccd"}, {"mode": "dcd", "accuracy": "candidates"},
                        {"mode": "dcd", "thickness": 0.1, "position_format": "q16", "quantization_box": box}):
            with self.subTest(options):
                error = self.refused(collided.InvalidArgument, "CONTACT_KIND_EDGE_TRIANGLE",
                                     self.session, kinds=["vt", "ee", "et"], **options)
                self.assertEqual(error.field, "spec.kinds[2]")

    def test_loose_elements_are_told_by_their_stencils(self):
        strand = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], float)
        drops = np.array([[[0.25, 0, 1], [5, 0, 0], [5.5, 0, 0]], [[0.25, 0, -1], [6, 0, 0], [4.5, 0, 0]]], float)
        session = self.session({"strand": {"vertices": strand, "edges": [[0, 1], [1, 2]]},
                                "drops": {"vertices": drops[0], "points": [0, 1, 2]}}, thickness=0.02)
        contacts = session.step({"drops": drops[1]})
        self.assertEqual(contacts.elements.tolist(), [[3, 0], [4, 4]])
        self.assertEqual(contacts.meshes.tolist(), [[1, 0], [1, 1]])
        self.assertEqual(contacts.stencils[:, 2:].tolist(), [[1, 1], [5, 5]])


class WithoutADaemon(Case):
    def test_ids_of_crossings_are_checked(self):
        layout = Layout.of({"folded": collided.Mesh(FOLDED, [[0, 1, 2], [0, 3, 4]])})
        for pair, problem in (((5, 2), "names 2; the scene has 2 elements"), ((6, 0), "names 6; the scene has 6 edges at most")):
            part = Part(contact_pb2.CONTACT_KIND_EDGE_TRIANGLE, 1, {"elements": np.array([pair], "<u4")})
            self.refused(collided.DataLoss, problem, check_part, part, layout)
        chunk = contact_pb2.ContactChunk(kind=contact_pb2.CONTACT_KIND_EDGE_TRIANGLE, count=1)
        self.refused(collided.DataLoss, "limits.kind is EDGE_TRIANGLE", check_limits, [chunk], True)

    def test_edges_are_numbered_as_the_conventions_say(self):
        hair = collided.Mesh(np.eye(3), edges=[[1, 0], [1, 2], [0, 1]], points=[2])
        layout = Layout.of({"folded": collided.Mesh(FOLDED, [[0, 1, 2], [0, 3, 4]]), "hair": hair})
        self.assertEqual(layout.edge_offsets.tolist(), [0, 6, 8])
        self.assertEqual(layout.corners[2:].tolist(), [[6, 5, 5], [6, 7, 7], [5, 6, 6], [7, 7, 7]])


class OneQuestion(Case):
    def test_detect_and_proximity_have_the_contacts_of_collidectl(self):
        random = np.random.default_rng(5)
        before = random.random((300, 3)).astype("<f4")
        after = (before + random.normal(0, 0.05, before.shape)).astype("<f4")
        triangles = np.arange(300).reshape(-1, 3)
        with tempfile.TemporaryDirectory() as folder:
            files = [os.path.join(folder, name) for name in ("a.obj", "b.obj")]
            for file, vertices in zip(files, (before, after)):
                lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.astype(float).tolist()]
                lines += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
                with open(file, "w", encoding="ascii") as out:
                    out.write("\n".join(lines))
            for mode, ours in (("ccd", collided.detect(before, after, triangles, server=self.server)),
                               ("dcd", collided.proximity(before, triangles, thickness=0.01, server=self.server))):
                inputs = files if mode == "ccd" else files[:1]
                rows = self.rows_of(folder, "--frames", *inputs, "--mode", mode, *(["--thickness", "0.01", "--kinds", "vt,ee"] if mode == "dcd" else []))
                self.assertGreater(len(rows), 30)
                self.assertEqual(ours.elements.tolist(), [[int(row["element_a"]), int(row["element_b"])] for row in rows])
                self.assertEqual(ours.stencils.tolist(), [[int(row[f"v{i}"]) for i in range(4)] for row in rows])
                self.assertEqual(ours.distance.tolist(), [float(row["distance"]) for row in rows])
                if mode == "ccd":
                    self.assertEqual(ours.toi.tolist(), [float(row["toi"]) for row in rows])

    def rows_of(self, folder, *words):
        out = os.path.join(folder, "out.csv")
        done = subprocess.run([COLLIDECTL, "detect", *words, "--out", out], capture_output=True, text=True,
                              env={**os.environ, "COLLIDED_DAEMON": str(DAEMON)})
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(out, encoding="ascii", newline="") as file:
            return list(csv.DictReader(file))

    def test_every_form_of_a_mesh_will_do(self):
        both = np.concatenate([FLOOR, TIP]), np.concatenate([FLOOR, lowered(2)])
        contacts = collided.detect(*both, [[0, 1, 2], [3, 4, 5]], server=self.server, accuracy="exact")
        self.expect_hit(contacts, 2)
        particles = collided.detect(*both, [[0, 1, 2]], particles=[3], edges=[[4, 5]], server=self.server)
        self.assertEqual(particles.vt.elements.tolist(), [[3, 0]])
        self.assertEqual(collided.detect(*(v.astype(float) for v in both), [[0, 1, 2], [3, 4, 5]],
                                         server=self.server).elements.tolist(), [[3, 0]])

    def test_without_a_server_it_starts_a_daemon_of_its_own(self):
        own = [collided.detect(TIP, lowered(1), ONE) for _ in range(2)]
        self.assertEqual([len(contacts) for contacts in own], [0, 0])
        with collided.Session(meshes()) as session:
            self.expect_hit(session.step({"tip": lowered(2)}), 2)
            self.assertTrue(session.is_local)
            guard = session.scene.client._own._process
            os.killpg(guard.pid, 9)
            guard.wait()
            assert_same(self, session.step({"tip": TIP}), self.fallen_and_risen())
            self.assertEqual(session.recreations, 1)

    def fallen_and_risen(self):
        session = self.session()
        session.step({"tip": lowered(2)})
        return session.step({"tip": TIP})

    def test_a_daemon_that_does_not_start_says_why(self):
        for option, why in (("--backend=abacus", "--backend: abacus not in"), ("--max-scenes=0", "--max-scenes: ")):
            daemon = collided.OwnDaemon(option, program=str(DAEMON))
            error = self.refused(collided.Unavailable, "did not become ready: " + why, lambda: daemon.address)
            self.assertNotIn("--help", str(error))

    def test_the_daemon_of_a_process_that_dies_dies_with_it(self):
        program = ("import collided, os\n"
                   "from collided.connection.own_daemon import shared_daemon\n"
                   "collided.Client().info\n"
                   "print(shared_daemon()._process.pid, flush=True)\n"
                   "os.kill(os.getpid(), 9)\n")
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True,
                              env={**os.environ, "COLLIDED_DAEMON": str(DAEMON)})
        guard = int(done.stdout)
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline:
            try:
                os.killpg(guard, 0)
            except ProcessLookupError:
                return
            time.sleep(0.02)
        self.fail("the daemon outlived its process")


if __name__ == "__main__":
    main()
