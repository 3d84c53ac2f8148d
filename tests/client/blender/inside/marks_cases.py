"""Marks: replaced, cleared, kept in files; errors; daemons."""

import os
import pathlib
import shlex
import tempfile

import bpy
from support import DAEMON, SERVER, Case, cube, drawn, lines, preferences, select, square, touched_faces, touched_vertices

DETECT, CLEAR = bpy.ops.collided.detect, bpy.ops.collided.clear


def everything():
    """Names of all data, and what objects carry."""
    data = {kind: sorted(block.name for block in getattr(bpy.data, kind))
            for kind in ("objects", "meshes", "collections", "materials", "node_groups")}
    carried = [(thing.name, thing.vertex_groups.keys(), thing.data.attributes.keys()) for thing in bpy.data.objects]
    return data, sorted(carried), [marker.name for marker in bpy.context.scene.timeline_markers]


class Marks(Case):
    def crossed(self):
        select(cube("cube"), cube("other", location=(1, 1, 1)))

    def test_clear_leaves_what_was_there(self):
        self.crossed()
        bpy.data.objects["cube"].vertex_groups.new(name="own")
        self.scene.timeline_markers.new("own", frame=3)
        self.scene.frame_end = 3
        before = everything()
        DETECT()
        bpy.ops.collided.detect_range()
        self.assertNotEqual(everything(), before)
        CLEAR()
        self.assertEqual(everything(), before)
        self.assertEqual(self.settings.summary, "")

    def test_findings_replace_earlier_ones(self):
        self.crossed()
        DETECT()
        first = everything()
        DETECT()
        self.assertEqual(everything(), first)
        bpy.data.objects["other"].location.x = 5
        bpy.context.view_layer.update()
        DETECT()
        self.assertEqual((len(lines("collided crossings")), touched_faces(bpy.data.objects["cube"])), (0, []))

    def test_marks_are_not_tested(self):
        self.crossed()
        DETECT()
        count = self.settings.summary
        for thing in bpy.data.objects:
            thing.select_set(True)
        DETECT()
        self.assertEqual(self.settings.summary, count)

    def test_marks_stay_in_the_file(self):
        self.crossed()
        DETECT()
        summary = self.settings.summary
        count = drawn("collided crossings")
        self.assertGreater(count, 0)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "saved.blend")
            bpy.ops.wm.save_as_mainfile(filepath=file)
            bpy.ops.wm.read_homefile(use_empty=True)
            bpy.ops.wm.open_mainfile(filepath=file)
            self.assertEqual(drawn("collided crossings"), count)
            self.assertEqual(bpy.context.scene.collided.summary, summary)
            CLEAR()
            self.assertEqual(len(lines("collided crossings")), 0)

    def test_select_needs_marks(self):
        self.crossed()
        self.assertEqual(bpy.ops.collided.select_faces(), {"CANCELLED"})

    def test_linked_meshes_are_tested_and_not_marked(self):
        self.crossed()
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "library.blend")
            bpy.ops.wm.save_as_mainfile(filepath=file)
            bpy.ops.wm.read_homefile(use_empty=True)
            preferences().server = SERVER
            with bpy.data.libraries.load(file, link=True) as (_, into):
                into.objects = ["cube"]
            linked = into.objects[0]
            bpy.context.collection.objects.link(linked)
            floor = square("cube")
            select(linked, floor)
            DETECT()
            self.assertGreater(len(lines("collided crossings")), 0)
            self.assertEqual((touched_faces(linked), touched_faces(floor)), ([], [0]))
            CLEAR()


class Errors(Case):
    def test_no_daemon_answers(self):
        select(cube("cube"), cube("other", location=(1, 1, 1)))
        DETECT()
        before = everything()
        with tempfile.TemporaryDirectory() as folder:
            preferences().server = f"unix:{folder}/socket"
            self.refused(DETECT, "no daemon answers at unix:")
        self.assertEqual(everything(), before)

    def test_preferences_that_cannot_be_used(self):
        cube("cube")
        preferences().token_file = "/no/such/token"
        for operator in (DETECT, bpy.ops.collided.detect_range):
            self.refused(operator, "the token file cannot be read: .*No such file")
        preferences().token_file = ""
        preferences().tls_key = "key.pem"
        self.refused(DETECT, "tls_certificate and tls_key go together")
        preferences().tls_key = ""
        preferences().server, preferences().program = "", "/no/such/daemon"
        self.refused(DETECT, "'/no/such/daemon' is not a file")
        preferences().program = "/bin/true"
        self.refused(DETECT, "daemon /bin/true did not become ready")

    def test_a_daemon_of_its_own(self):
        cube("cube")
        preferences().server, preferences().program = "", DAEMON
        DETECT()
        self.assertEqual(self.settings.summary, "No contacts")

    def test_what_a_daemon_has_no_room_for(self):
        from collided_blender.connection import stop_daemons

        self.addCleanup(stop_daemons)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        # No variable of Blender's environment reaches a daemon of its own, so a program of the user's sets the limit.
        program = pathlib.Path(folder.name, "small")
        program.write_text(f'#!/bin/sh\nexec {shlex.quote(DAEMON)} "$@" --max-triangles 4\n')
        program.chmod(0o755)
        cube("cube")
        preferences().server, preferences().program = "", str(program)
        self.refused(DETECT, "12 triangles.*fewer objects or no self contacts need less")

    def tearDown(self):
        for name in ("program", "token_file", "tls_key"):
            preferences().property_unset(name)

    def test_fast_without_a_distance(self):
        select(cube("cube"), cube("other", location=(1, 1, 2.001)))
        self.settings.accuracy = "FAST"
        self.refused(DETECT, "accuracy Fast needs a distance above 0")
        self.settings.distance = 0.01
        for level in ("FAST", "GUARDED", "CERTIFIED", "EXACT"):
            self.settings.accuracy = level
            DETECT()
            self.assertGreater(len(lines("collided contacts")), 0, level)
            self.assertTrue(touched_vertices(bpy.data.objects["cube"]))

    def test_a_package_that_cannot_be_imported(self):
        import sys

        from collided_blender import package
        hidden = {name: sys.modules.pop(name) for name in list(sys.modules) if name.split(".")[0] == "collided"}
        lib = pathlib.Path(package.__file__).parent / "lib"
        lib.rename(lib.with_name("elsewhere"))
        try:
            cube("cube")
            self.refused(DETECT, r"Blender's Python 3\S+ cannot use the package collided \(No module named 'collided'\)")
        finally:
            lib.with_name("elsewhere").rename(lib)
            sys.modules.update(hidden)
