"""collidectl detect, export and stream: known contacts, and their files.

Usage: detect_test.py COLLIDECTL DAEMON"""

import csv
import fractions
import itertools
import json
import os
import random
import re
import xml.etree.ElementTree

import support
from support import ONE_CPU, FRAME0, cube


class Meshes(support.CollidectlTest):
    """Files are meshes of one scene."""

    def found(self, *words):
        return json.loads(self.ok("detect", *words, *ONE_CPU, "--json"))

    def test_two_meshes_touch_or_do_not(self):
        ball, box, far = (self.put(name, cube(x)) for name, x in (("ball.obj", 0), ("box.obj", 1.5), ("far.obj", 4)))
        text = self.ok("detect", ball, box, *ONE_CPU)
        self.assertRegex(text, r"^ball and box touch: [1-9]\d* contacts \(.*[1-9]\d* triangle-triangle, [1-9]\d* edge-triangle\)\n"
                               r"  .*pairs touch; the first: edge \d-\d of b\w+ \w+ triangle \d+ of b\w+ at \([\d., ]+\)\n\nscene\n")
        self.assertTrue(self.ok("detect", ball, far, *ONE_CPU).startswith("ball and far do not touch\n"))
        found = self.found(ball, box)
        (pair,) = found["touching"]
        self.assertEqual((pair["meshes"], pair["contact_count"]), (["ball", "box"], found["contact_count"]))
        self.assertEqual((found["scene"]["mode"], found["scene"]["accuracy"], found["scene"]["kinds"]),
                         ("dcd", "exact", ["vt", "ee", "tt", "et"]))
        self.assertEqual((self.found(ball, far)["touching"], self.found(ball, far)["any_contact"]), ([], False))
        self.assertEqual(self.found(ball, far, "--report", "any")["found"], "ball and far do not touch")
        self.assertEqual(self.found(ball, box, "--report", "any")["found"], "ball and box touch")

    def test_a_side_that_only_touches_counts_and_a_hair_of_room_does_not(self):
        ball, box, near = (self.put(name, cube(x)) for name, x in (("ball.obj", 0), ("box.obj", 2), ("near.obj", 2.000000001)))
        self.assertTrue(self.found(ball, box)["any_contact"])
        self.assertFalse(self.found(ball, near)["any_contact"])
        self.assertRegex(self.found(ball, near, "--thickness", "0.01")["found"], "^ball and near touch at a thickness of 0.01: ")

    def test_a_mesh_may_be_thicker_than_others(self):
        ball, near, far = (self.put(name, cube(x)) for name, x in (("ball.obj", 0), ("a=b.obj", 2.5), ("far.obj", 5)))
        thick = ["--half-thickness", "ball=0.25", "--half-thickness", "a=b=0.125"]
        self.assertEqual(self.found(ball, near, *thick)["found"], "ball and a=b do not touch at a thickness of 0.375")
        found = self.found(ball, near, *thick, "--thickness", "0.125")
        self.assertRegex(found["found"], "^ball and a=b touch at a thickness of 0.5: ")
        self.assertEqual(found["scene"]["half_thickness"], {"ball": 0.25, "a=b": 0.125})
        self.assertNotIn("half_thickness", self.found(ball, near)["scene"])
        three = [ball, near, far, "--half-thickness", "ball=0.5"]
        self.assertRegex(self.found(*three)["found"], r"^ball and a=b touch at a thickness of 0.5: .*\nthe other 2 pairs do not touch$")
        self.assertEqual(self.found(ball, near, far, "--half-thickness", "far=0.1")["found"],
                         "none of the 3 meshes touch at half thicknesses of their own")
        self.assertRegex(self.ok("detect", *three, *ONE_CPU), r"\n  half_thickness\n    ball  0.5\n")
        fast = [ball, near, "--accuracy", "fast", "--kinds", "vt,ee"]
        self.refused(2, "needs a --thickness greater than 0", "detect", *fast, *ONE_CPU)
        self.assertTrue(self.found(*fast, "--half-thickness", "ball=0.6")["any_contact"])

    def test_a_half_thickness_that_cannot_be(self):
        ball, box = (self.put(name, cube(x)) for name, x in (("ball.obj", 0), ("box.obj", 1.5)))
        for word in ("ball", "ball=", "=1", "ball=x", "ball=-1", "ball=nan", "ball=inf", "ball=1e999"):
            self.refused(2, f"'{word}' is not NAME=LENGTH", "detect", ball, box, "--half-thickness", word)
        self.refused(2, "mesh 'ball' is named twice", "detect", ball, box, "--half-thickness", "ball=1", "--half-thickness", "ball=2")
        self.refused(2, "--half-thickness: the scene has no mesh 'bell'; there are ball, box", "detect", ball, box,
                     "--half-thickness", "bell=1", *ONE_CPU)
        self.refused(1, "spec.meshes[1].half_thickness is 1.0000000000000001e+300", "detect", ball, box, "--half-thickness", "box=1e300", *ONE_CPU)

    def test_three_meshes_are_told_by_pairs_and_a_mesh_alone_by_itself(self):
        files = [self.put(name, cube(x)) for name, x in (("a.obj", 0), ("b.obj", 1), ("c.obj", 9))]
        self.assertRegex(self.found(*files)["found"], r"^a and b touch: .*\)\n  .*\)\nthe other 2 pairs do not touch$")
        self.assertEqual(self.found(files[0], files[2], self.put("d.obj", cube(20)))["found"], "none of the 3 meshes touch")
        self.assertEqual(self.found(files[0])["found"], "a: no self-intersection")
        self.assertEqual(self.found(files[0], "--thickness", "0.5")["found"], "a does not touch itself at a thickness of 0.5")
        both = self.put("both.obj", cube(0) + re.sub(r"^f .*$", lambda f: "f " + " ".join(str(int(v) + 8) for v in f[0].split()[1:]), cube(1), flags=re.M))
        self.assertRegex(self.found(both)["found"], r"^both: (\d+ edges? goe?s? through .*, )?\d+ pairs touch; the first: edge .* at \(")
        self.assertRegex(self.found(both, "--thickness", "0.5")["found"], "^both touches itself at a thickness of 0.5: ")
        self.assertNotIn("both and both", self.found(both, files[2])["found"])
        self.assertEqual(self.found(files[0], files[0])["touching"][0]["meshes"], ["a", "a (2)"])

    def test_a_mesh_within_another_has_no_contact_and_is_told_why(self):
        text = self.found(self.put("shell.obj", cube(0, 9)), self.put("core.obj", cube(1, 1, 1)))["found"]
        self.assertIn("shell and core do not touch; ", text)
        self.assertIn("meshes are surfaces", text)

    def test_solids_are_inside_overlap_touch_or_are_apart(self):
        shell, inside, across, beside, apart = (self.put(name, cube(*where)) for name, where in (
            ("shell.obj", (0, 8)), ("inside.obj", (1, 2, 3.5)), ("across.obj", (7.5, 1, 3)), ("beside.obj", (8, 1, 3)), ("apart.obj", (9, 1, 3))))
        out, vtp, ply = (os.path.join(self.folder.name, "c." + ending) for ending in ("csv", "vtp", "ply"))
        found = self.found("--solid", shell, inside, "--out", out, "--vtp", vtp, "--ply", ply)
        self.assertEqual(found["found"], "inside is inside shell: 8 contacts (8 vertex-solid)\n  8 vertices of inside inside shell; the "
                                         "deepest, vertex 1 of inside, is 3 below the surface; out along (-1, 0, 0)")
        (pair,) = found["touching"]
        self.assertEqual((pair["state"], pair["inside_count"]), ("second_inside", [0, 8]))
        self.assertEqual(pair["deepest"], {"mesh": "inside", "vertex": 1, "depth": 3, "direction": [-1, 0, 0]})
        self.assertEqual((found["scene"]["solids"], found["scene"]["kinds"][-1]), (["shell", "inside"], "vs"))
        self.assertEqual((found["counts"]["contacts_vertex_solid"], found["counts"]["inside_out"]), (8, 0))
        rows = self.rows(out)
        self.assertEqual([(row["kind"], float(row["distance"]), row["signed_distance"]) for row in rows],
                         [("vs", depth, "") for depth in (-1, -3, -1, -2.5, -1, -2.5, -1, -2.5)])
        self.assertEqual([row["point_a_x"] for row in rows], ["1", "3"] * 4)
        (array,) = [a for a in xml.etree.ElementTree.parse(vtp).iter("DataArray") if a.get("Name") == "kind"]
        self.assertEqual(array.text.split(), ["5"] * 8)
        with open(ply, encoding="ascii") as file:
            self.assertIn("property double signed_distance\n", file.read())
        (pair,) = self.found("--solid", shell, across)["touching"]
        self.assertEqual((pair["state"], pair["inside_count"], pair["deepest"]["depth"]), ("overlapping", [0, 4], 0.5))
        (pair,) = self.found("--solid", shell, beside)["touching"]
        self.assertEqual((pair["state"], pair["inside_count"], pair["deepest"]), ("touching", [0, 0], None))
        self.assertEqual(self.found("--solid", shell, beside, "--kinds", "vs")["found"], "shell and beside touch")
        self.assertEqual(self.found("--solid", shell, apart)["found"], "shell and apart do not touch")
        self.assertRegex(self.found("--solid", shell, inside, apart)["found"], r"^inside is inside shell: .*\n.*\nthe other 2 pairs do not touch$")

    def test_solids_are_closed_and_those_that_are_named(self):
        shell, core, flat = self.put("shell.obj", cube(0, 9)), self.put("core.obj", cube(1, 1, 1)), self.put("flat.obj", support.FRAME0)
        self.refused(1, "spec.meshes[1].solid", "detect", "--solid", shell, flat, *ONE_CPU)
        self.refused(2, "--solid: the scene has no mesh 'bell'; there are shell, core", "detect", "--solid=bell", shell, core, *ONE_CPU)
        found = self.found("--solid=shell", shell, core, flat)
        self.assertEqual((found["scene"]["solids"], found["touching"][0]["state"]), (["shell"], "second_inside"))
        self.assertEqual(self.found("--solid=core", shell, core)["touching"], [])
        self.refused(1, "spec.meshes[0].solid", "detect", "--solid", shell, core, *ONE_CPU, "--part-devices", "cpu:0,cpu:0")

    def test_frames_follow_their_option_or_are_in_a_folder(self):
        folder = os.path.join(self.folder.name, "frames")
        os.mkdir(folder)
        for name, text in (("f2.obj", support.FRAME0), ("f10.obj", support.FRAME1), ("notes.txt", "")):
            with open(os.path.join(folder, name), "w", encoding="ascii") as file:
                file.write(text)
        by_option = self.found("--frames", self.frame0, self.frame1)
        self.assertRegex(by_option["found"], r"^a to b: there is contact, \d+ contacts?, the first at 0\.(49\d*|5) of the step$")
        for words in ([folder], ["--frames", folder]):
            self.assertEqual(self.found(*words)["earliest_toi"], by_option["earliest_toi"])
        self.refused(2, "it goes alone", "detect", self.frame0, folder)
        self.put("frames/f11.obj", support.FRAME1)
        self.refused(2, "there are 3: 'collidectl stream' plays them", "detect", folder)
        self.assertEqual(len(json.loads(self.ok("stream", folder, *ONE_CPU, "--json"))["per_frame"]), 3)
        self.refused(1, "two meshes go without --frames", "detect", "--frames", self.frame0, self.put("ball.obj", cube(0)))

    def test_a_frame_alone_is_a_mesh_however_it_is_named(self):
        folder = os.path.join(self.folder.name, "one")
        os.mkdir(folder)
        crossing = self.put("one/a.obj", cube(0) + re.sub(r"^f .*$", lambda f: "f " + " ".join(str(int(v) + 8) for v in f[0].split()[1:]), cube(1), flags=re.M))
        answers = []
        for words in ([crossing], ["--frames", crossing], [folder], ["--frames", folder]):
            found = self.found(*words)
            answers.append({key: found.get(key) for key in ("found", "touching", "contact_count", "counts", "earliest")})
            answers[-1].update({key: found["scene"][key] for key in ("mode", "accuracy", "kinds")})
            self.refused(2, "what was given stands still", "detect", *words, "--mode", "ccd")
        self.assertEqual(answers[0]["kinds"], ["vt", "ee", "tt", "et"])
        self.assertEqual(answers[1:], answers[:1] * 3)

    def test_polygons_that_bend_keep_their_triangles(self):
        quad = "v 0 0 0\nv {} 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n"  # convex, then concave at the second corner
        bent = self.found("--frames", self.put("q0.obj", quad.format("4 0")), self.put("q1.obj", quad.format("1 2")))
        self.assertEqual(bent["scene"]["triangles"], 2)

    def test_what_the_reader_changed_is_said(self):
        facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex {} 1 0\nendloop\nendfacet\n"
        stl = self.put("two.stl", "solid a\n" + facet.format(0) + facet.format(1) + "endsolid a\n")
        said = f"{stl}: welded 6 corners into 4 vertices"
        self.assertEqual(self.found(stl)["notes"], [said])
        self.assertIn(said + "\n", self.ok("detect", stl, *ONE_CPU))


def common_points(first, second, at):
    """Corners of what two triangles with area share, each as the sets of their vertices between which it is, in rationals."""
    for size_a, size_b in itertools.product((1, 2, 3), repeat=2):
        for some_a, some_b in itertools.product(itertools.combinations(first, size_a), itertools.combinations(second, size_b)):
            columns = [[*at[v], 1, 0] for v in some_a] + [[*(-x for x in at[v]), 0, 1] for v in some_b]
            weights = solution([list(row) for row in zip(*columns)], [0, 0, 0, 1, 1])
            if weights and min(weights) > 0:
                yield set(some_a), set(some_b)


def solution(rows, right):
    """Of linear equations, where there is exactly one; else nothing."""
    rows = [[fractions.Fraction(x) for x in (*row, value)] for row, value in zip(rows, right)]
    for column in range(len(rows[0]) - 1):
        pivot = next((row for row in rows[column:] if row[column]), None)
        if pivot is None:
            return None
        rows.remove(pivot)
        rows.insert(column, [x / pivot[column] for x in pivot])
        for i, row in enumerate(rows):
            if i != column and row[column]:
                rows[i] = [x - row[column] * y for x, y in zip(row, rows[column])]
    count = len(rows[0]) - 1
    return [row[-1] for row in rows[:count]] if not any(row[-1] for row in rows[count:]) else None


def has_area(triangle, at):
    (a, b, c) = (at[v] for v in triangle)
    u, v = [[x - y for x, y in zip(end, a)] for end in (b, c)]
    return any(u[i - 1] * v[i] != u[i] * v[i - 1] for i in range(3))


def intersects_itself(triangles, at):
    """Whether two triangles share more than what they have in common as parts of the mesh."""
    return any(not some_a <= set(first) & set(second) for first, second in itertools.combinations(triangles, 2)
               for some_a, _ in common_points(first, second, at))


class Self(support.CollidectlTest):
    """Is a mesh free of self-intersection?"""

    FOLDED = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 2 1 -1\nv 2 1.5 2\nf 1 2 3\nf 1 4 5\n"

    def asked(self, code, *words, where=ONE_CPU):
        done = support.ctl("detect", "--self", *words, *where, "--json")
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(done.stderr.count("not shown to be free of self-intersection"), int(code == 3))
        return json.loads(done.stdout)

    def test_a_mesh_is_free_or_crosses_or_touches_itself(self):
        free, folded, touching = (self.put(name, text) for name, text in (
            ("free.obj", cube(0)), ("folded.obj", self.FOLDED), ("touching.obj", self.FOLDED.replace("1.5 2", "1.5 0").replace("1 -1", "1 1"))))
        found = self.asked(0, free)
        self.assertEqual(found["found"], "free: no self-intersection")
        self.assertEqual(found["self_intersections"], [{"name": "free", "verdict": "free", "crossing_count": 0, "touching_count": 0,
                                                        "crossings": []}])
        found = self.asked(3, folded)
        self.assertEqual(found["found"], "folded: 1 edge goes through a triangle; the first: edge 3-4 through triangle 0 at (2, 1.16667, 0)")
        (one,) = found["self_intersections"]
        self.assertEqual((one["verdict"], one["crossing_count"], one["touching_count"]), ("intersects", 1, 0))
        self.assertEqual([(c["kind"], c["edge"], c["flags"]) for c in one["crossings"]], [("edge_triangle", [3, 4], ["certified"])])
        (one,) = self.asked(3, touching)["self_intersections"]
        self.assertEqual((one["verdict"], one["crossing_count"]), ("intersects", 0))
        self.assertGreater(one["touching_count"], 0)
        self.assertIn(("vertex_triangle", [2, 1.5, 0]), [(c["kind"], c["point"]) for c in one["crossings"]])

    def test_it_does_not_depend_on_what_contacts_are_asked_for(self):
        free, folded = self.put("free.obj", cube(0)), self.put("folded.obj", self.FOLDED)
        for words in (["--thickness", "9"], ["--half-thickness", "free=1"], ["--kinds", "tt"], ["--report", "any"], ["--exclude-rings", "2"],
                      ["--accuracy", "guarded"], ["--accuracy", "candidates"], ["--position-format", "f32"]):
            found = self.asked(0, free, *words)
            self.assertEqual((found["found"], found["self_intersections"][0]["verdict"]), ("free: no self-intersection", "free"), words)
            words = [word.replace("free", "folded") for word in words]
            self.assertEqual(self.asked(3, folded, *words)["self_intersections"][0]["crossing_count"], 1, words)

    def test_positions_are_those_of_the_file(self):
        """A vertex 2^-40 above a face, and on it."""
        text = self.FOLDED.replace("1.5 2", "1.5 {}").replace("1 -1", "1 1")
        self.asked(0, self.put("above.obj", text.format(2**-40)), "--position-format", "f32")
        self.asked(3, self.put("on.obj", text.format(0)), "--position-format", "f32")

    def test_several_meshes_are_told_one_by_one(self):
        files = [self.put("free.obj", cube(0)), self.put("folded.obj", self.FOLDED)]
        found = self.asked(3, *files)
        self.assertEqual([one["verdict"] for one in found["self_intersections"]], ["free", "intersects"])
        self.assertIn("free and folded touch: ", found["found"])
        self.assertTrue(found["found"].endswith("free: no self-intersection\nfolded: 1 edge goes through a triangle; the first: edge 3-4 "
                                                "through triangle 0 at (2, 1.16667, 0)"))
        self.assertNotIn("self_intersections", json.loads(self.ok("detect", *files, *ONE_CPU, "--json")))

    def test_what_is_not_covered_is_said(self):
        flat = self.put("flat.obj", cube(0) + "v 5 5 5\nv 6 6 6\nv 9 9 9\nf 9 10 11\n")
        found = self.asked(3, flat)
        self.assertEqual(found["found"], "flat: no self-intersection found, but not all is covered: 1 triangle without area, 12")
        self.assertEqual((found["self_intersections"][0]["verdict"], found["self_intersections"][0]["uncovered"]),
                         ("uncovered", ["1 triangle without area, 12"]))
        twice = self.put("twice.obj", cube(0) + "v 5 5 5\nv 6 5 5\nv 5 6 5\nf 9 10 11\nf 10 11 9\nf 10 9 11\n")
        self.assertIn("covered: 2 triangles listed again, the first 13", self.asked(3, twice)["found"])
        hair = self.put("hair.obj", cube(0) + "v 5 5 5\nv 6 5 5\nl 9 10\n")
        self.assertIn("covered: 1 loose edge or point", self.asked(3, hair)["found"])

    def test_frames_that_move_are_refused(self):
        self.refused(2, "--self tests meshes that stand still", "detect", "--self", "--frames", self.frame0, self.frame1)

    def test_it_is_true_of_random_meshes(self):
        """Against rationals: closed surfaces and pairs of triangles with common corners, on a small lattice."""
        shapes = [(5, [(0, 1, 2), (0, 3, 4)]), (4, [(0, 1, 2), (0, 1, 3)]), (5, [(0, 1, 2), (0, 2, 3), (0, 3, 4)]),
                  (6, [(0, 1, 2), (3, 4, 5)]), (5, [(0, 1, 3), (1, 2, 3), (2, 0, 3), (1, 0, 4), (2, 1, 4), (0, 2, 4)])]
        with self.daemon() as server:
            verdicts = self.judged(shapes, 200, ["--server", server])
        self.assertTrue(50 < sum(verdicts) < 150, sum(verdicts))

    def judged(self, shapes, count, where):
        """Verdicts on so many meshes."""
        numbers, verdicts = random.Random(7), []
        while len(verdicts) < count:
            vertices, triangles = shapes[len(verdicts) % len(shapes)]
            at = [[numbers.randrange(4) for _ in range(3)] for _ in range(vertices)]
            if not all(has_area(triangle, at) for triangle in triangles):
                continue
            mesh = self.put("mesh.obj", "".join("v {} {} {}\n".format(*p) for p in at) +
                            "".join("f {} {} {}\n".format(*(v + 1 for v in t)) for t in triangles))
            expected = intersects_itself(triangles, at)
            (one,) = self.asked(3 if expected else 0, mesh, where=where)["self_intersections"]
            self.assertEqual(one["verdict"], "intersects" if expected else "free", (at, triangles))
            verdicts.append(expected)
        return verdicts


class Detect(support.CollidectlTest):
    def test_ccd_finds_the_known_contact(self):
        out = os.path.join(self.folder.name, "c.csv")
        summary = json.loads(self.ok("detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--out", out, "--json"))
        rows = self.rows(out)
        self.assertEqual(summary["contact_count"], len(rows))
        self.assertEqual(summary["scene"]["triangles"], 2)
        self.assertEqual(summary["scene"]["backend"], "cpu")
        self.assertEqual(summary["scene"]["position_format"], "f32")
        vt = [row for row in rows if row["kind"] == "vt"]
        self.assertEqual([(row["element_a"], row["element_b"]) for row in vt], [("3", "0")])
        self.assertEqual([vt[0][v] for v in ("v0", "v1", "v2", "v3")], ["3", "0", "1", "2"])
        self.assertAlmostEqual(float(vt[0]["toi"]), 0.5, places=3)
        self.assertEqual(summary["earliest_toi"], float(vt[0]["toi"]))
        self.assertLessEqual(summary["earliest_toi"], 0.5)
        self.assertIs(summary["any_contact"], True)
        self.assertEqual(summary["warnings"], [])
        self.assertEqual([summary["scene"][name] for name in ("accuracy", "report", "kinds", "delta")],
                         ["certified", "all", ["vt", "ee"], 0])

    def test_every_level_finds_the_known_contact(self):
        for level in ("fast", "guarded", "certified", "exact"):
            out = os.path.join(self.folder.name, level)
            words = ["--accuracy", level, "--delta", "1e-5", "--out", out, "--json"]
            summary = json.loads(self.ok("detect", "--frames", self.frame0, self.frame1, *ONE_CPU, *words))
            self.assertEqual((summary["scene"]["accuracy"], summary["scene"]["delta"]), (level, 1e-5))
            vt = [row for row in self.rows(out) if row["kind"] == "vt"]
            self.assertEqual([(row["element_a"], row["element_b"]) for row in vt], [("3", "0")])
            self.assertTrue(set(vt[0]["flags"].split("|")) <= {"", "certified", "near", "capped", "initial"})
        self.assertEqual(vt[0]["flags"], "certified")

    def test_lines_and_points_of_an_obj_are_loose_elements(self):
        def frame(name, z, points="2"):
            path = os.path.join(self.folder.name, name)
            with open(path, "w") as file:
                file.write(f"v 0 0 0\nv 0.5 0 {z}\nv 1 0 0\nl 1 3\np {points}\n")
            return path

        out = os.path.join(self.folder.name, "loose.csv")
        summary = json.loads(self.ok("detect", "--frames", frame("a.obj", 1), frame("b.obj", -1), *ONE_CPU, "--out", out, "--json"))
        self.assertEqual(summary["earliest"]["stencil"], [1, 0, 2, 2])
        self.assertEqual([(row["kind"], row["element_a"], row["element_b"]) for row in self.rows(out)], [("vt", "1", "0")])
        others = frame("c.obj", -1, points="1")
        self.refused(1, "has other loose edges or points", "detect", "--frames", frame("a.obj", 1), others, *ONE_CPU)

    def test_a_csv_has_weights_points_and_normals(self):
        out = os.path.join(self.folder.name, "c.csv")
        self.ok("detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--accuracy", "exact", "--out", out)
        (row,) = [row for row in self.rows(out) if row["kind"] == "vt"]
        self.assertEqual([float(row[name]) for name in ("w0", "w1")], [0.25, 0.25])
        for point in ("point_a", "point_b"):
            for axis, expected in zip("xyz", (1, 1, 0)):
                self.assertAlmostEqual(float(row[f"{point}_{axis}"]), expected, places=5)
        self.assertEqual([float(row["normal_" + axis]) for axis in "xyz"], [0, 0, 1])

    def test_a_scene_in_parts_has_the_same_contacts(self):
        frames, parts = [self.frame0, self.frame1], ["--part-devices", "cpu:0,cpu:0,cpu:0"]
        files = [os.path.join(self.folder.name, name) for name in ("one.csv", "parts.csv")]
        one, in_parts = (json.loads(self.ok("detect", "--frames", *frames, *ONE_CPU, *words, "--out", file, "--json"))
                         for words, file in zip(([], parts), files))
        self.assertEqual(*(self.rows(file) for file in files))
        self.assertEqual((in_parts["scene"]["part_devices"], "part_devices" in one["scene"]), (["cpu:0"] * 3, False))
        self.assertEqual(sum(part["contact_count"] for part in in_parts["parts"]), len(self.rows(files[0])))
        self.assertAlmostEqual(sum(part["share"] for part in in_parts["parts"]), 1)

    def test_a_contact_that_parts_says_so(self):
        apart = self.put("apart.obj", FRAME0.replace("v 1 1 1\n", "v 1 1 0.1\n"))
        further = self.put("further.obj", FRAME0)
        out = os.path.join(self.folder.name, "c.csv")
        self.ok("detect", "--frames", apart, further, *ONE_CPU, "--thickness", "0.2", "--out", out)
        self.assertIn("separating", [word for row in self.rows(out) for word in row["flags"].split("|")])

    def test_files_for_paraview_hold_what_the_csv_holds(self):
        out, vtp, ply = (os.path.join(self.folder.name, "c." + ending) for ending in ("csv", "vtp", "ply"))
        words = ["detect", "--frames", self.frame0, self.frame1, *ONE_CPU]
        summary = json.loads(self.ok(*words, "--out", out, "--vtp", vtp, "--ply", ply, "--json"))
        self.assertEqual([summary[name] for name in ("out", "vtp", "ply")], [out, vtp, ply])
        rows = self.rows(out)
        self.assertGreater(len(rows), 0)
        piece = xml.etree.ElementTree.parse(vtp).getroot().find("PolyData/Piece")
        self.assertEqual((piece.get("NumberOfPoints"), piece.get("NumberOfVerts")), (str(len(rows)),) * 2)
        arrays = {array.get("Name"): array.text.split() for array in piece.iter("DataArray")}
        columns = {"points": "point_a_x point_a_y point_a_z", "other_point": "point_b_x point_b_y point_b_z", "toi": "toi",
                   "distance": "distance", "normal": "normal_x normal_y normal_z", "elements": "element_a element_b",
                   "stencil": "v0 v1 v2 v3", "weights": "w0 w1"}
        for name, cells in columns.items():
            self.assertEqual(arrays[name], [row[cell] for row in rows for cell in cells.split()], name)
        self.assertEqual(arrays["kind"], [{"vt": "1", "ee": "2"}[row["kind"]] for row in rows])
        self.assertEqual(arrays["connectivity"], [str(i) for i in range(len(rows))])
        self.assertEqual(arrays["offsets"], [str(i + 1) for i in range(len(rows))])
        with open(ply, encoding="ascii") as file:
            header, lines = file.read().split("end_header\n")
        self.assertIn(f"element vertex {len(rows)}\n", header)
        names = re.findall(r"property \w+ (\w+)", header)
        self.assertEqual([line.split()[:3] for line in lines.splitlines()],
                         [[row["point_a_" + axis] for axis in "xyz"] for row in rows])
        for line, row in zip(lines.splitlines(), rows):
            found = dict(zip(names, line.split(), strict=True))
            self.assertEqual([found[name] for name in ("toi", "element_a", "v3", "w1")],
                             [row[name] for name in ("toi", "element_a", "v3", "w1")])

    def test_files_for_paraview_without_contacts_or_times(self):
        vtp, ply = (os.path.join(self.folder.name, "c." + ending) for ending in ("vtp", "ply"))
        self.ok("detect", "--frames", self.frame0, self.frame0, *ONE_CPU, "--vtp", vtp, "--ply", ply)
        self.assertEqual(xml.etree.ElementTree.parse(vtp).find("PolyData/Piece").get("NumberOfPoints"), "0")
        self.ok("detect", self.frame1, *ONE_CPU, "--mode", "dcd", "--thickness", "1", "--vtp", vtp, "--ply", ply)
        piece = xml.etree.ElementTree.parse(vtp).find("PolyData/Piece")
        self.assertGreater(int(piece.get("NumberOfPoints")), 0)
        self.assertNotIn("toi", [array.get("Name") for array in piece.iter("DataArray")])
        for option in ("--vtp", "--ply"):
            self.refused(2, f"{option} needs contact points", "detect", self.frame1, "--mode", "dcd", "--kinds", "tt", option,
                         vtp)
            self.refused(2, f"{option} is a file here", "detect", "--frames", self.frame0, self.frame1, option, "-")
            self.refused(1, "Is a directory", "detect", "--frames", self.frame0, self.frame1, option, self.folder.name)

    def test_encoded_positions_miss_nothing(self):
        words = ["detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--position-format", "q16"]
        summary = json.loads(self.ok(*words, "--json"))
        self.assertEqual(summary["scene"]["position_format"], "q16")
        self.assertEqual(summary["bytes_in"], 2 * 6 * 6)
        self.assertTrue(0.499 < summary["earliest_toi"] <= 0.5, summary)
        self.refused(1, "EXACT", *words, "--accuracy", "exact")

    def test_an_advance_tells_how_far_it_went(self):
        words = ["detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--json"]
        self.assertNotIn("advanced", json.loads(self.ok(*words)))
        free = json.loads(self.ok(*words, "--advance"))
        self.assertTrue(0.4 < free["advanced"] < 0.5, free)
        wide = json.loads(self.ok(*words, "--advance", "--min-separation", "0.5"))
        self.assertEqual(wide["scene"]["min_separation"], 0.5)
        self.assertTrue(0 < wide["advanced"] < 0.25, wide)
        still = json.loads(self.ok("detect", "--frames", self.frame0, self.frame0, *ONE_CPU, "--json", "--advance"))
        self.assertEqual(still["advanced"], 1)

    def test_an_advance_tells_what_it_shortened(self):
        words = ["detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--json", "--advance"]
        whole = json.loads(self.ok(*words))
        self.assertAlmostEqual(whole["way"], whole["advanced"], 5)
        for mode, count in ("per-mesh", 1), ("per-vertex", 1):
            each = json.loads(self.ok(*words, "--advance-mode", mode))
            self.assertEqual(each["shortened_count"], count, mode)
            self.assertGreaterEqual(each["way"], whole["way"] - 1e-5, mode)

    def test_an_advance_counts_what_limits_it(self):
        words = ["detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--advance"]
        self.assertNotIn("limit_count", json.loads(self.ok(*words, "--json")))
        for mode in "all-or-one", "per-mesh", "per-vertex":
            limited = json.loads(self.ok(*words, "--advance-mode", mode, "--limits", "--json"))
            self.assertEqual(limited["limit_count"], 1, mode)

    def test_reports(self):
        frames = [self.frame0, self.frame1]
        out = os.path.join(self.folder.name, "c.csv")
        earliest = json.loads(self.ok("detect", "--frames", *frames, *ONE_CPU, "--report", "earliest", "--out", out, "--json"))
        self.assertEqual((earliest["scene"]["report"], earliest["contact_count"], len(self.rows(out))), ("earliest", 1, 1))
        hit = json.loads(self.ok("detect", "--frames", *frames, *ONE_CPU, "--report", "any", "--out", out, "--json"))
        self.assertEqual((hit["any_contact"], hit["contact_count"], self.rows(out)), (True, None, []))
        miss = json.loads(self.ok("detect", "--frames", self.frame0, self.frame0, *ONE_CPU, "--report", "any", "--json"))
        self.assertIs(miss["any_contact"], False)

    def test_the_earliest_contact_is_named(self):
        for report in ("earliest", "all"):
            words = ["detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--report", report]
            summary = json.loads(self.ok(*words, "--json"))
            contact = summary["earliest"]
            self.assertEqual((contact["kind"], contact["elements"], contact["stencil"], contact["flags"]),
                             ("vertex_triangle", [3, 0], [3, 0, 1, 2], ["certified"]))
            self.assertEqual(contact["toi"], summary["earliest_toi"])
            self.assertRegex(self.ok(*words), r"earliest\n  kind +vertex_triangle\n  elements +3, 0\n")
        played = json.loads(self.ok("stream", "--scene", "funnel", "--scale", "0.2", "--frames", "3", "--t0", "0.9",
                                    *ONE_CPU, "--json"))
        self.assertEqual("earliest" in played, played["any_contact"])

    def test_what_is_not_counted_is_no_zero(self):
        words = ["detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--report", "any"]
        summary = json.loads(self.ok(*words, "--json"))
        self.assertEqual([summary["contact_count"], summary["counts"]["contacts_vertex_triangle"]], [None, None])
        self.assertNotIn("earliest_toi", summary)
        self.assertRegex(self.ok(*words), r"contact_count +not counted\nany_contact +yes\n")

    def test_reports_are_for_people(self):
        text = self.ok("detect", "--frames", self.frame0, self.frame1, *ONE_CPU)
        self.assertRegex(text, r"\n  delta +automatic\n")
        self.assertRegex(text, r"\nstep +[0-9.,e-]+ ms\n")
        self.assertRegex(text, r"\ndevice_bytes +[0-9]{1,3}(,[0-9]{3})+ bytes\n")
        self.assertNotRegex(text, r"[1-9][0-9]{4}", "four digits are enough, and thousands are separated")
        self.assertNotIn("[", text)

    def test_an_output_that_cannot_be_written_is_found_before_the_work(self):
        words = ["detect", "--frames", self.frame0, self.frame1]
        nothing = {"COLLIDED_DAEMON": "/nonexistent"}
        missing = os.path.join(self.folder.name, "none", "c.csv")
        self.refused(1, f"--out {missing}: cannot be written: No such file or directory", *words, "--out", missing,
                     **nothing)
        self.refused(1, "Is a directory", *words, "--out", self.folder.name, **nothing)
        left = os.path.join(self.folder.name, "c.csv")
        self.refused(1, "COLLIDED_DAEMON", *words, "--out", left, **nothing)
        self.assertFalse(os.path.exists(left))

    def test_a_result_is_printed_even_if_its_file_cannot_be_written(self):
        done = support.ctl("detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--out", "/dev/full", "--json")
        self.assertEqual(done.returncode, 1)
        self.assertIs(json.loads(done.stdout)["any_contact"], True)
        self.assertEqual(done.stderr, "collidectl: /dev/full: cannot be written: No space left on device\n")

    def test_standard_output_takes_the_contacts(self):
        done = support.ctl("detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--out", "-", cwd=self.folder.name)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = list(csv.DictReader(done.stdout.splitlines()))
        self.assertEqual(("vt", "3", "0"), tuple(rows[0][name] for name in ("kind", "element_a", "element_b")))
        self.assertIn("any_contact", done.stderr)
        self.assertEqual(sorted(os.listdir(self.folder.name)), ["a.obj", "b.obj"])
        self.refused(2, "both want standard output", "detect", "--frames", self.frame0, self.frame1, "--out", "-", "--json")

    def test_triangles_that_cross(self):
        out = os.path.join(self.folder.name, "c.csv")
        words = ["--mode", "dcd", "--kinds", "tt", "--out", out, "--json"]
        summary = json.loads(self.ok("detect", self.frame1, *ONE_CPU, *words))
        self.assertEqual(summary["scene"]["kinds"], ["tt"])
        self.assertEqual(summary["counts"]["contacts_triangle_triangle"], 1)
        row = self.rows(out)[0]
        self.assertEqual([row[name] for name in ("kind", "element_a", "element_b", "v0", "toi")],
                         ["tt", "0", "1", "", ""])

    def test_edges_that_go_through_neighbours(self):
        mesh = self.put("folded.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 2 1 -1\nv 2 1.5 2\nf 1 2 3\nf 1 4 5\n")
        out = os.path.join(self.folder.name, "c.csv")
        words = ["detect", mesh, *ONE_CPU, "--out", out]
        alone = json.loads(self.ok(*words, "--kinds", "et", "--json"))
        self.assertEqual((alone["scene"]["kinds"], alone["counts"]["contacts_edge_triangle"]), (["et"], 1))
        (pair,) = alone["touching"]
        self.assertEqual({key: pair[key] for key in ("meshes", "contact_count", "crossing_count", "touching_count")},
                         {"meshes": ["folded"] * 2, "contact_count": 1, "crossing_count": 1, "touching_count": 0})
        (crossing,) = pair["crossings"]
        self.assertEqual((crossing["kind"], crossing["elements"], crossing["edge"]), ("edge_triangle", [5, 0], [3, 4]))
        for x, expected in zip(crossing["point"], (2, 7 / 6, 0)):
            self.assertAlmostEqual(x, expected, places=6)
        (row,) = self.rows(out)
        self.assertEqual([row[name] for name in ("kind", "element_a", "element_b", "v0", "flags")],
                         ["et", "5", "0", "", "certified"])
        self.assertAlmostEqual(float(row["w0"]), 0.5)
        self.assertAlmostEqual(float(row["w1"]), 7 / 24)
        self.assertEqual([row["point_a_x"], row["point_b_z"]], ["2", "0"])
        self.assertIn("folded touches itself: 1 contact (1 edge-triangle)\n  1 edge goes through a triangle; the first: edge 3-4 through "
                      "triangle 0 at (2, 1.16667, 0)\n", self.ok(*words, "--kinds", "et"))

    def test_a_tie_is_told_apart(self):
        floor = self.put("floor.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n")
        corner = self.put("corner.obj", "v 1 1 0\nv 1 1 3\nv 1 2 -3\nf 1 2 3\n")  # one corner is in the floor, a side goes through it
        out = os.path.join(self.folder.name, "c.csv")
        found = json.loads(self.ok("detect", floor, corner, *ONE_CPU, "--kinds", "et", "--out", out, "--json"))
        (pair,) = found["touching"]
        self.assertEqual((pair["crossing_count"], pair["touching_count"]), (1, 1))
        flags = sorted("|".join(crossing["flags"]) for crossing in pair["crossings"])
        self.assertEqual(flags, ["certified", "certified|touching"])
        self.assertEqual(sorted(row["flags"] for row in self.rows(out)), flags)
        self.assertIn("\n  1 edge goes through a triangle, 1 pair touches; the first: edge ", found["found"])
        self.assertRegex(found["found"], r"edge \d-\d of corner (on|through) triangle 0 of floor at \(1, 1\.?5?, 0\)$")

    def test_contours_are_lines_of_files(self):
        """Two tetrahedra that overlap: one closed contour. Two neighbours: a line from their corner to the crossing."""
        solid = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
        first = self.put("first.obj", "v 0 0 0\nv 6 0 0\nv 0 6 0\nv 0 0 6\n" + solid)
        second = self.put("second.obj", "v 1 1 1\nv 7 1 1\nv 1 7 1\nv 1 1 7\n" + solid)
        folded = self.put("folded.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 2 1 -1\nv 2 1.5 2\nf 1 2 3\nf 1 4 5\n")
        for meshes, is_closed in ((first, second), True), ((folded,), False):
            out, vtp, ply = (os.path.join(self.folder.name, "c." + ending) for ending in ("csv", "vtp", "ply"))
            self.ok("detect", *meshes, *ONE_CPU, "--out", out, "--vtp", vtp, "--ply", ply)
            rows = [row for row in self.rows(out) if row["kind"] == "et"]
            points = [[row["point_a_" + axis] for axis in "xyz"] for row in rows] + [["0", "0", "0"]] * (not is_closed)
            piece = xml.etree.ElementTree.parse(vtp).getroot().find("PolyData/Piece")
            arrays = {part: {array.get("Name"): array.text.split() for array in piece.iterfind(f"{part}/DataArray")}
                      for part in ("PointData", "CellData", "Points", "Verts", "Lines")}
            self.assertEqual((piece.get("NumberOfPoints"), piece.get("NumberOfVerts"), piece.get("NumberOfLines")),
                             (str(len(points)), str(len(rows)), "1"))
            self.assertEqual(arrays["Points"]["points"], sum(points, []))
            self.assertEqual(arrays["PointData"]["kind"], ["4"] * len(rows) + ["0"] * (not is_closed))
            self.assertEqual(arrays["CellData"]["contour"], ["-1"] * len(rows) + ["0"])
            self.assertEqual(arrays["CellData"]["closed"], ["0"] * len(rows) + [str(int(is_closed))])
            self.assertEqual(arrays["CellData"]["meshes"][-2:], ["0", "1" if is_closed else "0"])
            line = arrays["Lines"]["connectivity"]
            self.assertEqual(arrays["Lines"]["offsets"], [str(len(line))])
            self.assertEqual(sorted(map(int, line[:-1] if is_closed else line)), list(range(len(points))))
            self.assertEqual(line[0] == line[-1], is_closed)
            with open(ply, encoding="ascii") as file:
                header, body = file.read().split("end_header\n")
            lines = [row.split() for row in body.splitlines()]
            self.assertIn(f"element vertex {len(points)}\n", header)
            self.assertIn(f"element edge {len(line) - 1}\n", header)
            self.assertEqual([row[:3] for row in lines[:len(points)]], points)
            self.assertEqual(lines[len(points):], [list(ends) for ends in zip(line, line[1:])])
            widths = {len(row) for row in lines[:len(points)]}
            self.assertEqual(widths, {header.count("property ") - 2})

    def test_contacts_of_what_stands_still_have_features_and_some_cover_others(self):
        floor = self.put("floor.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
        spike = self.put("spike.obj", "v 0.5 0.5 0.0009765625\nv 0.25 0.5 1\nv 0.75 0.625 1\nf 1 2 3\n")
        out, vtp, ply = (os.path.join(self.folder.name, "c." + ending) for ending in ("csv", "vtp", "ply"))
        words = ["detect", floor, spike, *ONE_CPU, "--thickness", "0.02", "--json"]
        files = ["--kinds", "vt,ee", "--out", out, "--vtp", vtp, "--ply", ply]
        self.assertEqual(json.loads(self.ok(*words))["covered_count"], 3)
        every = json.loads(self.ok(*words, *files))
        self.assertEqual((every["contact_count"], every["covered_count"], every["touching"][0]["contact_count"]), (4, 3, 4))
        rows = self.rows(out)
        self.assertEqual([row["features"] for row in rows],
                         ["vertex|side_2", "vertex|side_3|same_as_before", *["inside|end_1|same_as_before"] * 2])
        self.assertEqual(["covered" in row["flags"].split("|") for row in rows], [False, True, True, True])
        (array,) = [a for a in xml.etree.ElementTree.parse(vtp).iter("DataArray") if a.get("Name") == "features"]
        self.assertEqual(array.text.split(), [str(byte) for byte in (2, 3 + 64, 4 + 64, 4 + 64)])
        with open(ply, encoding="ascii") as file:
            self.assertEqual([line.split()[-2] for line in file.read().split("end_header\n")[1].splitlines()], array.text.split())
        kept = json.loads(self.ok(*words, *files, "--kept"))
        self.assertEqual((kept["contact_count"], kept["covered_count"], kept["touching"][0]["contact_count"]), (4, 3, 1))
        self.assertRegex(kept["found"], r": 1 contact \(1 vertex-triangle\)$")
        self.assertEqual(self.rows(out), rows[:1])
        self.assertRegex(self.ok(*words[:-1], "--kept"), r"\ncovered_count +3\n")

    def test_candidates_leave_uncomputed_fields_empty(self):
        out = os.path.join(self.folder.name, "c.csv")
        self.ok("detect", "--frames", self.frame0, self.frame1, *ONE_CPU, "--accuracy", "candidates", "--out", out)
        rows = self.rows(out)
        self.assertEqual([row["kind"] for row in rows], sorted((row["kind"] for row in rows), reverse=True))
        self.assertTrue(all(row["toi"] == row["distance"] == "" for row in rows))

    def test_dcd_and_double_positions(self):
        near = self.put("near.obj", FRAME0.replace("v 1 1 1\n", "v 1 1 0.1\n"))
        summary = json.loads(self.ok("detect", near, "--mode", "dcd", "--thickness", "0.2", *ONE_CPU, "--json"))
        self.assertGreaterEqual(summary["contact_count"], 1)
        self.assertEqual(summary["scene"]["position_format"], "f64")

    def test_export_detect_and_stream_agree_on_the_scene(self):
        out = os.path.join(self.folder.name, "frames")
        small = ["--scene", "funnel", "--scale", "0.2", "--frames", "2"]
        for ending in ("ply", "obj"):
            self.ok("export", *small, "--t0", "0.9", "--out", out, "--format", ending)
        frames = [os.path.join(out, f"funnel_000{i}.ply") for i in (0, 1)]
        one = json.loads(self.ok("detect", "--frames", *frames, *ONE_CPU, "--json"))
        two = json.loads(self.ok("detect", "--frames", *(f.replace(".ply", ".obj") for f in frames), *ONE_CPU, "--json"))
        self.assertEqual(one["counts"], two["counts"])
        played = json.loads(self.ok("stream", *small, *ONE_CPU, "--json"))
        self.assertEqual(played["scene"]["triangles"], one["scene"]["triangles"])
        self.assertEqual(played["frames"], 2)
        self.assertEqual(list(played["median"]), ["total_ms", "queue_ms", "step_ms", "stage_ms"])
        self.assertEqual(list(played["last_frame"]["counts"]), list(one["counts"]))
        self.assertEqual(played["any_contact"], played["contact_count"] > 0)
        self.assertEqual(played["warnings"], [])


if __name__ == "__main__":
    support.main()
