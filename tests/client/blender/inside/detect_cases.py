"""Contacts and crossings of a frame are those of the package, whatever the objects are made of."""

import bmesh
import bpy
import numpy as np
from support import Case, asked, ball, cube, lines, mesh, seen, select, square, touched_faces, touched_vertices, values

DETECT = bpy.ops.collided.detect


class Contacts(Case):
    def expect_as_asked(self, *things, distance, **options):
        """The marks are where the package finds contacts, and there are some."""
        self.settings.distance = distance
        DETECT()
        contacts = asked(*things, mode="dcd", thickness=distance, **options)
        first, second = contacts.points
        np.testing.assert_allclose(lines("collided contacts"), np.stack([first, second], axis=1), atol=1e-6)
        np.testing.assert_allclose(values("collided contacts", "distance")[:, 0], contacts.distance, atol=1e-6)
        self.assertGreater(len(contacts), 0)
        return contacts

    def test_contacts_are_those_of_the_package(self):
        things = cube("cube"), ball("ball", 0.7, (1.75, 0.2, 0.1))
        select(*things)
        self.settings.self_contacts = False
        self.settings.distance = 0.1
        contacts = asked(*things, mode="dcd", thickness=0.1)
        between = contacts.between("cube", "ball")
        DETECT()
        np.testing.assert_allclose(lines("collided contacts"), np.stack(between.points, axis=1), atol=1e-6)
        self.assertEqual(self.settings.summary, f"{len(between)} contacts")
        self.assertGreater(len(between), 0)

    def test_self_contacts_leave_out_neighbours(self):
        fold = mesh("fold", [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (2, 0, .2), (2, 1, .2), (0, 0, .1), (0, 1, .1)], (),
                    [(0, 1, 2, 3), (1, 4, 5, 2), (4, 6, 7, 5)])
        self.settings.skip_rings = 0
        self.settings.distance = 0.15
        DETECT()
        everything = len(lines("collided contacts"))
        self.settings.skip_rings = 1
        DETECT()
        self.assertTrue(0 < len(lines("collided contacts")) < everything)
        self.settings.self_contacts = False
        DETECT()
        self.assertEqual(self.settings.summary, "No contacts")
        self.assertEqual(touched_vertices(fold), [])

    def test_crossings_are_the_curve_that_both_surfaces_share(self):
        shift = np.array([1, 0.9, 0.8])
        first, second = cube("first"), cube("second", location=shift)
        select(first, second)
        DETECT()
        segments = lines("collided crossings").astype(float)
        self.assertEqual(self.settings.summary, f"{len(segments)} crossings")
        for centre in (np.zeros(3), shift):
            np.testing.assert_allclose(np.abs(segments - centre).max(axis=2), 1, atol=1e-5)
        self.assertAlmostEqual(np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum(), 2 * (2 - shift).sum(), places=4)
        self.assertEqual(touched_faces(first), [1, 3, 5])
        self.assertEqual(touched_faces(second), [0, 2, 4])

    def test_triangles_in_one_plane_are_marked_where_they_overlap(self):
        first = mesh("first", [(0, 0, 0), (2, 0, 0), (0, 2, 0)], (), [(0, 1, 2)])
        second = mesh("second", [(0.5, 0.5, 0), (3, 0.5, 0), (0.5, 3, 0)], (), [(0, 1, 2)])
        select(first, second)
        DETECT()
        (segment,) = lines("collided crossings")
        np.testing.assert_allclose(segment, [(1.25, 1.25, 0)] * 2)

    def test_scaled_mirrored_turned_and_parented(self):
        parent = mesh("parent", [], location=(5, 6, 7))
        things = cube("cube", scale=(-1, 1, 1.5)), square(location=(0, 0, 1.52), scale=(1, -2, 1))
        for thing in things:
            thing.parent = parent
        parent.rotation_euler = (0.3, 0.4, 0.5)
        bpy.context.view_layer.update()
        select(*things)
        self.settings.skip_rings = 0
        contacts = self.expect_as_asked(*things, distance=0.05)
        self.assertEqual(touched_vertices(things[0]), [1, 3, 5, 7])
        self.assertTrue((contacts.distance < 0.021).all())


class Objects(Case):
    def tip(self, height, **options):
        return mesh("tip", [(0.3, 0.2, height), (0.4, 0.2, height + 3), (0.3, 0.4, height + 3)], (), [(0, 1, 2)], **options)

    def test_modifiers_that_make_faces(self):
        thing, tip = cube("cube"), self.tip(3.01)
        array = thing.modifiers.new("array", "ARRAY")
        array.use_relative_offset, array.use_constant_offset, array.constant_offset_displace = False, True, (0, 0, 2)
        select(thing, tip)
        self.settings.self_contacts, self.settings.distance = False, 0.02
        self.assertEqual(len(seen(thing)[0]), 16)
        DETECT()
        np.testing.assert_allclose(lines("collided contacts"), [[(0.3, 0.2, 3.01), (0.3, 0.2, 3)]], atol=1e-6)
        self.assertEqual((touched_vertices(thing), touched_faces(thing)), ([], []))
        self.assertEqual(touched_vertices(tip), [0])

    def test_modifiers_that_move_vertices(self):
        thing, tip = cube("cube"), self.tip(2.01)
        thing.modifiers.new("displaced", "DISPLACE").direction = "Z"
        thing.modifiers["displaced"].mid_level = 0
        select(thing, tip)
        self.settings.distance = 0.02
        DETECT()
        np.testing.assert_allclose(lines("collided contacts"), [[(0.3, 0.2, 2.01), (0.3, 0.2, 2)]], atol=1e-6)
        self.assertEqual(touched_faces(thing), [5])

    def test_a_face_of_many_corners(self):
        angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
        star = [(r * np.cos(a), r * np.sin(a), 0) for a, r in zip(angles, [2, 0.9] * 6)]
        thing = mesh("star", [*star, (9, 9, 9), (9, 8, 9), (8, 9, 9)], (), [(12, 13, 14), tuple(range(12))])
        select(thing, self.tip(0.01))
        self.settings.distance = 0.02
        DETECT()
        self.assertEqual(len(lines("collided contacts")), 1)
        self.assertEqual(touched_faces(thing), [1])
        select(thing)
        bpy.ops.collided.select_faces()
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual([face.select for face in thing.data.polygons], [False, True])
        self.assertEqual([v.index for v in thing.data.vertices if v.select], list(range(12)))

    def test_loose_edges_and_vertices(self):
        floor = square()
        wire = mesh("wire", [(0.5, 0.2, 0.01), (1, 0.2, 3)], [(0, 1)])
        dust = mesh("points", [(1, 0.3, 0.005), (1, 0.3, 5)])
        select(floor, wire, dust)
        self.settings.distance = 0.02
        DETECT()
        ends = lines("collided contacts")
        self.assertEqual(sorted(ends[:, 0, 2].astype(float).round(4)), [0.005, 0.01])
        self.assertEqual([touched_vertices(thing) for thing in (wire, dust)], [[0], [0]])

    def test_curves_and_texts(self):
        bpy.ops.curve.primitive_bezier_circle_add(location=(0, 0, 0.01))
        curve = bpy.context.object
        curve.data.bevel_depth = 0.05
        select(square(), curve)
        DETECT()
        self.assertGreater(len(lines("collided crossings")), 0)

    def test_nothing_to_test(self):
        bpy.ops.object.select_all(action="DESELECT")
        self.refused(DETECT, "poll")
        mesh("empty", [])
        self.refused(DETECT, "no selected object has faces, edges or vertices")
        cube("cube")
        self.assertEqual(DETECT(), {"FINISHED"})

    def test_what_is_hidden_or_not_selected_is_left_out(self):
        things = cube("a"), cube("b", location=(1, 1, 1)), cube("c", location=(0.5, 0.5, 0.5)), cube("d", location=(0.2, 0.2, 0.2))
        select(*things)
        things[1].hide_set(True)
        things[2].hide_viewport = True
        things[3].select_set(False)
        DETECT()
        self.assertEqual(self.settings.summary, "No contacts")

    def test_objects_that_share_a_mesh_share_its_marks(self):
        first = cube("first")
        second = bpy.data.objects.new("second", first.data)
        bpy.context.collection.objects.link(second)
        second.location = 0, 0, 2.01
        bpy.context.view_layer.update()
        select(first, second)
        self.settings.distance = 0.02
        DETECT()
        self.assertEqual(touched_vertices(first), list(range(8)))
        self.assertEqual(touched_faces(first), list(range(6)))

    def test_names_may_be_anything(self):
        things = cube("vertices"), cube("é" * 31, location=(1, 1, 1)), cube("triangles", location=(0.5, 0.4, 0.3))
        select(*things)
        DETECT()
        self.assertTrue(all(touched_faces(thing) for thing in things))

    def test_edit_mode_counts_what_is_edited(self):
        thing = cube("cube")
        select(thing, square(location=(0, 0, 3)))
        bpy.context.view_layer.objects.active = thing
        bpy.ops.object.mode_set(mode="EDIT")
        edited = bmesh.from_edit_mesh(thing.data)
        bmesh.ops.translate(edited, vec=(0, 0, 2.5), verts=edited.verts)
        DETECT()
        self.assertEqual(bpy.context.mode, "EDIT_MESH")
        self.assertGreater(len(lines("collided crossings")), 0)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(touched_faces(thing), [0, 1, 2, 3])

    def test_positions_that_are_not_finite(self):
        cube("cube").data.vertices[3].co.x = float("nan")
        self.refused(DETECT, "cube: the position of vertex 3 is not finite")
