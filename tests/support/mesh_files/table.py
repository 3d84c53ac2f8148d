#!/usr/bin/env python3
"""Mesh files as exporters, other programs and attackers write them, each with what a reader must make of it.

usage: table.py FOLDER      writes all files and table.json, for the tests of the readers in C++ and in Python

Expectations are stated by hand, or follow from how a file was made. Each row has the file's name. A file that must be refused
has `error`: the whole message behind the file's name. The others have some of these:
- `vertices` are the positions in their order; `vertex_count`, `triangles`, `edges` and `points` are counts;
- `twice_area` is the vector sum of all triangles' cross products. It is integers, so that a test compares it without rounding, and no
  triangle may point against it;
- `notes` are the reader's remarks.
"""

import base64
import json
import pathlib
import random
import struct
import sys

ROWS = []
SQUARE = [(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)]
TENT = SQUARE + [(1, 1, .5), (2, 1, .5), (1, 2, .5)]
PLANE = {"vertices": SQUARE, "triangles": 2, "twice_area": (0, 0, 32), "notes": []}
TENT_READ = {"vertices": TENT, "triangles": 3, "notes": []}


def add(name, data, **expected):
    ROWS.append((name, data if isinstance(data, bytes) else data.encode(), expected))


def refuse(name, data, error):
    add(name, data, error=error)


def expands(name, data):
    """A small file that stands for a mesh without end."""
    size = len(data if isinstance(data, bytes) else data.encode())
    refuse(name, data, f": expands to more than {2 ** 23 + 4 * size} vertices and corners (a node counts as 64), the limit for {size} bytes")


# OBJ

def obj(vertices, *lines):
    return "".join(f"v {x} {y} {z}\n" for x, y, z in vertices) + "".join(line + "\n" for line in lines)


def add_obj():
    tent = obj(TENT, "f 1 2 3", "f 1 3 4", "f 5 6 7")
    for name, text in (("lf", tent), ("crlf", tent.replace("\n", "\r\n")), ("cr", tent.replace("\n", "\r")),
                       ("mixed", tent.replace("\n", "\r", 3).replace("\n", "\r\n", 3)), ("no_end", tent.rstrip("\n")),
                       ("comments", "# first\n" + tent.replace("\nf", " # \\\n#f 9 9 9\nf") + "#"),
                       ("continued", tent.replace("f 1 2 3", "f 1 \\\n2 \\\n3")),
                       ("groups", "mtllib a#b.mtl\no x\n" + tent.replace("f 5", "g a b\nusemtl c\ns off\nf 5"))):
        add(f"tent_{name}.obj", text, **TENT_READ)
    add("negative.obj", obj(SQUARE, "f -4 -3 -2 -1", "v 9 9 9"), vertex_count=5, triangles=2, twice_area=(0, 0, 32))
    add("slashes.obj", obj(SQUARE, "vt 0 0", "vn 0 0 1", "f 1//1 2/1 3/1/1 4//1"), **PLANE)
    add("faces_first.obj", "f 1 2 3 4\n" + obj(SQUARE), **PLANE)
    add("w.obj", "v 0 0 0 2\nv 8 0 0 2\nv 4 4 0 1\nv 0 -4 0 -1\nf 1 2 3 4\n", **PLANE)
    add("w_third.obj", "v 1 0 0 3\nv 1 1 0\nv 0 1 0 1.0\nf 1 2 3\n", vertices=[(1 / 3, 0, 0), (1, 1, 0), (0, 1, 0)], triangles=1)
    add("colours.obj", "".join(f"v {x} {y} {z} 0.5 0.5 0.5\n" for x, y, z in SQUARE[:2])
        + "".join(f"v {x} {y} {z} 1 0 0 1\n" for x, y, z in SQUARE[2:]) + "f 1 2 3 4\n", **PLANE)
    add("lines_and_points.obj", obj(SQUARE, "l 1 2/5 3", "p 1 -1"), vertex_count=4, triangles=0, edges=2, points=2)
    add("repeated.obj", obj(SQUARE, "f 1 1 2 3 3 4 1", "f 1 1 2", "f 1 2 1"), vertices=SQUARE, triangles=2, twice_area=(0, 0, 32),
        notes=["dropped 3 repeated corners", "dropped 2 faces with fewer than 3 different corners"])
    add("repeated_once.obj", obj(SQUARE, "f 1 2 3 4", "f 2 2 2"), vertices=SQUARE, triangles=2,
        notes=["dropped 1 face with fewer than 3 different corners"])
    add("vertical_tab.obj", obj(SQUARE, "f 1 2 3 4").replace(" ", "\x0b").replace("v", "\x0cv"), **PLANE)
    add("continued_to_the_end.obj", obj(SQUARE, "f 1 2 3 4\\").removesuffix("\n"), **PLANE)
    add("continued_often.obj", obj(SQUARE, "f 1 2 3 4 " + "\\\n" * 300000), **PLANE)
    add("long_numbers.obj", obj(SQUARE, "f 1 2 3 +" + "0" * 100000 + "4").replace("4 4 0", "4 4 0." + "0" * 100000), **PLANE)
    add("underflow.obj", "v 0 0 0\nv 1 0 1e-400\nv 0 1 -1e-999\nf 1 2 3\n", vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], triangles=1)
    refuse("plus_minus.obj", "v 0 +-1 0\n", ":1: '+-1' is not a number")
    refuse("plus_minus_index.obj", obj(SQUARE, "f 1 2 +-1"), ":5: '+-1' is not a number")
    refuse("parenthesis.obj", "v 0 nan(1) 0\n", ":1: 'nan(1)' is not a number")
    refuse("zero_byte.obj", b"v 0 1\0 0\n", ":1: '1\ufffd' is not a number")
    refuse("large_whole.obj", "v 0 0 1" + "0" * 400 + "\n", ":1: number 1" + "0" * 39 + " is out of range")
    refuse("slash.obj", obj(SQUARE, "f 1 2 3 a/4"), ":5: 'a' is not a number")
    refuse("w_infinite.obj", "v 0 0 0\nv 1 0 0 inf\n", ":2: w is not finite")
    refuse("w_zero.obj", "v 0 0 0\nv 1 0 0 0\n", ":2: w is 0: the vertex is at infinity")
    refuse("five.obj", "v 0 0 0 1 2\n", ":1: the vertex has 5 numbers; it needs 3, 4 with a weight, or 6 or 7 with a colour")
    refuse("nan.obj", "v 0 0 0\n\nv 0 nan 0\n", ":3: position nan is not finite")
    refuse("large.obj", "v 0 0 1e999\n", ":1: number 1e999 is out of range")
    refuse("word.obj", "v 0 zero 0\n", ":1: 'zero' is not a number")
    refuse("underscore.obj", "v 0 1_0 0\n", ":1: '1_0' is not a number")
    refuse("short.obj", "v 0 0\n", ":1: a number is missing")
    refuse("index.obj", obj(SQUARE, "f 1 2 5"), ":5: vertex index 5 is out of range; there are 4 vertices")
    refuse("index_0.obj", obj(SQUARE, "f 1 2 0"), ":5: vertex index 0 is out of range")
    refuse("index_back.obj", obj(SQUARE, "f 1 2 -5"), ":5: vertex index -5 is out of range")
    refuse("two.obj", obj(SQUARE, "f 1 2"), ":5: the face has 2 corners; it needs 3")
    refuse("line.obj", obj(SQUARE, "l 1"), ":5: the line has 1 vertex; it needs 2")
    refuse("no_faces.obj", obj(SQUARE), ": has no faces")
    refuse("empty.obj", "", ": has 0 vertices; a mesh needs 3")
    refuse("all_dropped.obj", obj(SQUARE, "f 1 1 2"), ": has no faces")


# Polygons

def polygon(name, corners, **expected):
    """A face in a plane, turned and moved by integers; the expectation is exact."""
    for i, (u, v, at) in enumerate((((1, 0, 0), (0, 1, 0), (0, 0, 0)), ((0, 2, 1), (3, 0, -1), (5, -7, 11)),
                                    ((1, 2, 3), (-3, 1, 2), (1000, 2000, 3000)))):
        points = [tuple(at[k] + x * u[k] + y * v[k] for k in range(3)) for x, y in corners]
        text = obj(points, "f " + " ".join(str(j + 1) for j in range(len(points))))
        if "error" in expected:
            refuse(f"{name}_{i}.obj", text, f":{len(points) + 1}: {expected['error']}")
            continue
        area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(corners, corners[1:] + corners[:1]))
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        add(f"{name}_{i}.obj", text, triangles=len(points) - 2, twice_area=tuple(area * n for n in normal), notes=[])


def add_polygons():
    polygon("l_shape", [(3, 0), (3, 1), (1, 1), (1, 3), (0, 3), (0, 0)])
    polygon("l_shape_clockwise", [(3, 0), (0, 0), (0, 3), (1, 3), (1, 1), (3, 1)])
    polygon("arrow", [(0, 0), (4, 2), (0, 4), (3, 2)])
    polygon("comb", [(0, 0), (8, 0), (8, 5), (7, 1), (6, 5), (5, 1), (4, 5), (3, 1), (2, 5), (1, 1), (0, 5)])
    polygon("spiral", [(0, 0), (9, 0), (9, 9), (1, 9), (1, 3), (6, 3), (6, 6), (4, 6), (4, 5), (5, 5), (5, 4), (2, 4), (2, 8), (8, 8),
                       (8, 1), (0, 1)])
    polygon("straight_corners", [(0, 0), (1, 0), (2, 0), (4, 0), (4, 2), (4, 4), (0, 4), (0, 1)])
    polygon("bridge_to_a_hole", [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)])
    polygon("touches_a_side", [(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)])
    polygon("many_corners", [(i, i * i) for i in range(-40, 41)])
    polygon("bow_tie", [(0, 0), (4, 4), (4, 0), (0, 2)], error="the face of 4 corners crosses itself")
    polygon("even_bow_tie", [(0, 0), (4, 4), (4, 0), (0, 4)], error="the face of 4 corners crosses itself")
    polygon("pentagram", [(0, 10), (6, -8), (-10, 3), (10, 3), (-6, -8)], error="the face of 5 corners crosses itself")
    polygon("wound_twice", [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (4, 0), (4, 4), (0, 4)], error="the face of 8 corners crosses itself")
    polygon("crosses_at_a_corner", [(0, 0), (4, 0), (4, 4), (2, 0), (1, -2)], error="the face of 5 corners crosses itself")
    chance = random.Random(7)
    for i in range(40):  # the land under a skyline
        heights = [chance.randint(1, 9) for _ in range(chance.randint(2, 12))]
        top = [(x, y) for x, y in enumerate(heights)][::-1]
        corners = [(0, 0), (len(heights) - 1, 0), *top]
        start = chance.randrange(len(corners))
        corners = corners[start:] + corners[:start]
        polygon(f"skyline_{i}", corners if i % 2 else corners[::-1])
    add("collapsed.obj", obj([(1, 1, 1)] * 4 + SQUARE, "f 1 2 3 4", "f 5 6 7 8"), triangles=4, twice_area=(0, 0, 32))
    add("straight.obj", obj([(0, 0, 0), (1, 2, 3), (2, 4, 6), (3, 6, 9)], "f 1 2 3 4"), triangles=2, twice_area=(0, 0, 0))
    add("warped.obj", obj([(0, 0, 0), (4, 0, 1), (4, 4, 0), (0, 4, 1)], "f 1 2 3 4"), triangles=2, twice_area=(0, 0, 32))
    small, large = 1e-300, 1e300
    for name, scale in (("tiny", small), ("huge", large)):
        add(f"{name}_concave.obj", obj([(x * scale, y * scale, 0) for x, y in ((0, 0), (4, 2), (0, 4), (3, 2))], "f 1 2 3 4"), triangles=2)


# PLY

def ply(body, order="ascii", vertices=7, faces=2, kind="double", count="uchar", index="int", extra="", element="face"):
    head = f"ply\nformat {order} 1.0\ncomment end_header is a word\nelement vertex {vertices}\n"
    head += "".join(f"property {kind} {axis}\n" for axis in "xyz")
    head += f"obj_info x\nelement {element} {faces}\nproperty list {count} {index} vertex_indices\n{extra}end_header\n"
    return head.encode() + (body if isinstance(body, bytes) else body.encode())


def add_ply():
    body = "".join(f"{x} {y} {z}\n" for x, y, z in TENT) + "4 0 1 2 3\n3 4 5 6\n"
    add("ascii.ply", ply(body), **TENT_READ)
    add("ascii_crlf.ply", ply(body).replace(b"\n", b"\r\n"), **TENT_READ)
    add("ascii_cr.ply", ply(body).replace(b"\n", b"\r"), **TENT_READ)
    for order, sign in (("binary_little_endian", "<"), ("binary_big_endian", ">")):
        for kind, letter in (("float", "f"), ("double", "d")):
            for (count, c), (index, i) in ((("uchar", "B"), ("int", "i")), (("uint8", "B"), ("uint8", "B")), (("char", "b"), ("short", "h")),
                                           (("ushort", "H"), ("uint", "I")), (("int32", "i"), ("uint16", "H"))):
                data = b"".join(struct.pack(sign + "3" + letter, *p) for p in TENT)
                data += b"".join(struct.pack(f"{sign}{c}{len(f)}{i}", len(f), *f) for f in ((0, 1, 2, 3), (4, 5, 6)))
                add(f"{order}_{kind}_{count}_{index}.ply", ply(data, order, kind=kind, count=count, index=index), **TENT_READ)
    data = b"".join(struct.pack("<3d", *p) for p in TENT) + struct.pack("<B4iB3i", 4, 0, 1, 2, 3, 3, 4, 5, 6)
    head_cr = ply("", "binary_little_endian").replace(b"\n", b"\r")
    add("binary_cr.ply", head_cr + data, **TENT_READ)
    first = struct.pack("<d", 0.0)[:-8] + b"\n\0\0\0\0\0\0\0"  # data that begins with a line feed
    add("binary_cr_line_feed.ply", head_cr + first + data[8:], triangles=3, vertex_count=7)
    add("binary_crlf.ply", ply("", "binary_little_endian").replace(b"\n", b"\r\n") + data, **TENT_READ)
    add("tristrips.ply", ply("0 0 0\n4 0 0\n0 4 0\n4 4 0\n8 0 0\n8 4 0\n0 0 4\n" + "9 0 1 2 3 -1 1 4 3 5\n", faces=1, count="int",
                             element="tristrips"), triangles=4, twice_area=(0, 0, 64), notes=[])
    add("faces_first.ply", b"ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nelement vertex 3\n"
        b"property float x\nproperty float y\nproperty float z\nend_header\n3 0 1 2\n0 0 0\n4 0 0\n0 4 0\n", triangles=1)
    edges = "element edge 1\nproperty int vertex1\nproperty int vertex2\n"
    add("edges.ply", ply(body + "0 1\n", extra=edges), **{**TENT_READ, "notes": ["ignored 1 edge"]})
    add("other_elements.ply", ply(body + "0 1\n", extra=edges.replace("edge", "material")), **TENT_READ)
    add("more_words.ply", ply(body + "# the end\n"), **{**TENT_READ, "notes": ["ignored 3 words after the last element"]})
    add("more_bytes.ply", ply("", "binary_little_endian") + data + b"more", **{**TENT_READ, "notes": ["ignored 4 bytes after the last element"]})
    add("vertical_tab.ply", ply(body.replace(" ", "\x0b").replace("\n", "\x0c")), **TENT_READ)
    add("bom.ply", b"\xef\xbb\xbf" + ply(body), **TENT_READ)
    add("whole_floats.ply", ply(body.replace("4 0 1", "4.0 0 1e0")), **TENT_READ)
    add("odd_values.ply", ply(body.replace("\n3 4", " 0.5\n3 4") + " nan 1e999\n", extra="property int a\n").replace(b"6 nan", b"6\nnan"),
        **{**TENT_READ, "notes": ["ignored 1 word after the last element"]})
    refuse("two_lists.ply", ply(body, extra="property list uchar int vertex_index\n"), ":11: element face has two lists of vertices")
    refuse("property_twice.ply", ply(body, extra="element a 1\nproperty int a\nproperty list uchar int a\n"),
           ":13: element a has the property 'a' twice")
    refuse("list_twice.ply", ply(body, extra="property list uchar int vertex_indices\n"), ":11: element face has two lists of vertices")
    refuse("element_twice.ply", ply(body, extra="element vertex 1\nproperty int a\n"), ":11: the header has the element 'vertex' twice")
    refuse("no_name.ply", ply(body, extra="property int\n"), ":11: the property has no name")
    refuse("half_length.ply", ply(body.replace("4 0 1 2 3", "4.5 0 1 2 3")), ": face 0: a list's length 4.5 is not an integer")
    refuse("half_index.ply", ply(body.replace("4 0 1", "4 0 1.5")), ": face 0: vertex index 1.5 is not an integer")
    refuse("plus_minus.ply", ply(body.replace("4 0 1", "4 0 +-1")), ":19: '+-1' is not a number")
    refuse("negative_length.ply", ply(body, count="char").replace(b"4 0 1 2 3", b"-1"), ": face 0: a list of -1 does not fit in the file")
    refuse("long_list.ply", ply(body, count="uint").replace(b"4 0 1 2 3", b"18446744073709551615"), ": is cut off within element face")
    refuse("long_list_binary.ply", ply("", "binary_little_endian", count="uint") + data[:7 * 24] + b"\xff" * 4, ": is cut off within element face")
    add("concave.ply", ply("0 0 0\n4 2 0\n0 4 0\n3 2 0\n4 0 1 2 3\n", vertices=4, faces=1), triangles=2, twice_area=(0, 0, 4))
    add("repeated.ply", ply("0 0 0\n4 0 0\n4 4 0\n0 4 0\n5 0 1 1 2 3\n3 0 1 0\n", vertices=4), triangles=2, twice_area=(0, 0, 32),
        notes=["dropped 1 repeated corner", "dropped 1 face with fewer than 3 different corners"])
    refuse("points_only.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           b"end_header\n0 0 0\n4 0 0\n0 4 0\n", ": has no faces")
    refuse("no_list.ply", b"ply\nformat ascii 1.0\nelement vertex 0\nelement face 1\nproperty int a\nend_header\n1\n",
           ": element face lacks the list vertex_indices")
    refuse("index.ply", ply(body.replace("3 4 5 6", "3 4 5 7")), ": face 1: vertex index 7 is out of range; there are 7 vertices")
    refuse("word.ply", ply(body.replace("4 0 1", "4 zero 1")), ":19: 'zero' is not a number")
    refuse("float_index.ply", ply(body, index="float"), ":10: vertex_indices must be of an integer type")
    refuse("giant.ply", ply("", vertices=4294967295), ": is cut off: 4294967295 of element vertex do not fit in the 0 bytes that follow the header")
    refuse("no_ply.ply", b"plx\n", ": does not begin with 'ply'")
    refuse("header.ply", b"ply\nformat ascii 1.0\n", ": is cut off in its header")
    refuse("keyword.ply", b"ply\nformat ascii 1.0\nwhat 1\nend_header\n", ":3: 'what' is not a PLY keyword")
    refuse("type.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\nend_header\n", ":4: type 'real' is not a PLY type")
    refuse("nan.ply", ply("0 0 0\n0 nan 0\n0 4 0\n3 0 1 2\n", vertices=3, faces=1), ": vertex 1 has a position that is not finite")


# STL

CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
CUBE_FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
CUBE_READ = {"vertex_count": 8, "triangles": 12, "twice_area": (0, 0, 0), "notes": ["welded 36 corners into 8 vertices"]}


def ascii_stl(faces, name="a"):
    facets = "".join(" facet normal 0 0 0\n  outer loop\n" + "".join("   vertex {} {} {}\n".format(*p) for p in face)
                     + "  endloop\n endfacet\n" for face in faces)
    return f"solid {name}\n{facets}endsolid {name}\n"


def binary_stl(faces, header=b"", count=None):
    data = header.ljust(80, b" ") + struct.pack("<I", len(faces) if count is None else count)
    return data + b"".join(struct.pack("<12fH", 0, 0, 0, *(x for p in face for x in p), 0) for face in faces)


def add_stl():
    cube = [[CUBE[v] for v in face] for face in CUBE_FACES]
    text = ascii_stl(cube)
    add("cube.stl", text, **CUBE_READ)
    add("cube_crlf.stl", text.replace("\n", "\r\n"), **CUBE_READ)
    add("cube_cr.stl", text.replace("\n", "\r"), **CUBE_READ)
    add("cube_upper.stl", text.upper(), **CUBE_READ)
    add("cube_one_line.stl", text.replace("\n", " ").replace("solid a ", "solid a\n", 1), **CUBE_READ)
    add("cube_comments.stl", text.replace("  endloop", "# half\n  endloop # facet"), **CUBE_READ)
    add("two_solids.stl", ascii_stl(cube[:6], "solid facet normal") + ascii_stl(cube[6:], ""), **CUBE_READ)
    add("cube_binary.stl", binary_stl(cube), **CUBE_READ)
    add("cube_binary_solid.stl", binary_stl(cube, b"solid by an exporter"), **CUBE_READ)
    add("cube_binary_more.stl", binary_stl(cube) + b"more", vertex_count=8, triangles=12,
        notes=["ignored 4 bytes after the last facet", "welded 36 corners into 8 vertices"])
    add("minus_zero.stl", binary_stl([[(0., 0., 0.), (4, 0, 0), (4, 4, 0)], [(-0., 0., -0.), (4, 4, 0), (0, 4, 0)]]), vertex_count=4, triangles=2,
        twice_area=(0, 0, 32), notes=["welded 6 corners into 4 vertices"])
    add("degenerate.stl", ascii_stl([cube[0], [CUBE[0], CUBE[0], CUBE[1]]]), triangles=1, vertex_count=3,
        notes=["welded 6 corners into 3 vertices", "dropped 1 face with fewer than 3 different corners"])
    add("bom.stl", "\ufeff" + text, **CUBE_READ)
    add("vertical_tab.stl", text.replace(" vertex", "\x0bvertex").replace("\n  ", "\x0c\n"), **CUBE_READ)
    add("one_facet.stl", ascii_stl([[(0, 0, 0), (1, 0, 0), (0, 1, 0)]]), triangles=1, vertex_count=3, twice_area=(0, 0, 1), notes=[])
    add("doubles.stl", ascii_stl([[(0.1, 0, 0), (1e-300, 1, 0), (0, 0, 1)]]), vertices=[(.1, 0, 0), (1e-300, 1, 0), (0, 0, 1)], triangles=1)
    refuse("cut_ascii.stl", text[:-len("endsolid a\n")], ": is cut off: 'endsolid' is missing")
    refuse("cut_loop.stl", text[:text.index("endloop")], ": is cut off: 'endloop' is missing")
    refuse("cut_binary.stl", binary_stl(cube)[:-1], ": is cut off, or no STL: its 12 facets need 684 bytes; it has 683")
    refuse("giant.stl", binary_stl(cube, count=0xFFFFFFFF), ": is cut off, or no STL: its 4294967295 facets need 214748364834 bytes; it has 684")
    refuse("short.stl", b"STL", ": is cut off, or no STL: it has 3 bytes; the header alone has 84")
    refuse("empty.stl", binary_stl([]), ": has 0 vertices; a mesh needs 3")
    refuse("empty_ascii.stl", ascii_stl([]), ": has 0 vertices; a mesh needs 3")
    refuse("nan.stl", binary_stl([cube[0], [(0, 0, 0), (1, 0, float("nan")), (0, 1, 0)]]), ": facet 1: a position is not finite")
    refuse("word.stl", text.replace("vertex 0 0 1", "vertex 0 zero 1", 1), ":5: 'zero' is not a number")
    refuse("keyword.stl", text.replace("endfacet", "endface", 1), ":8: 'endface' stands where 'endfacet' must")


# OFF

def add_off():
    square = "".join("{} {} {}\n".format(*p) for p in SQUARE)
    add("plain.off", "OFF\n4 1 0\n" + square + "4 0 1 2 3\n", **PLANE)
    add("same_line.off", "OFF 4 1 0\n" + square + "4 0 1 2 3\n", **PLANE)
    add("no_edges.off", "OFF\n4 1\n" + square + "4 0 1 2 3\n", **PLANE)
    add("no_keyword.off", "4 1 0\n" + square + "4 0 1 2 3\n", **PLANE)
    add("comments.off", "# first\nOFF # kind\n\n# counts\n4 1 0 # all\n" + square.replace("\n", " # at\n\n") + "# face\n4 0 1 2 3 # f\n", **PLANE)
    add("cr.off", ("OFF\n4 1 0\n" + square + "4 0 1 2 3\n").replace("\n", "\r"), **PLANE)
    add("colours.off", "COFF\n4 1 0\n" + square.replace("\n", " 255 0 0 255\n") + "4 0 1 2 3 0.5 0.5 0.5\n", **PLANE)
    add("normals.off", "NOFF\n4 1 0\n" + square.replace("\n", " 0 0 1\n") + "4 0 1 2 3\n", **PLANE)
    add("all.off", "STCN4OFF\n4 1 0\n" + "".join("{} {} {} 2 0 0 1 9 9 9 9 0 0\n".format(*(2 * x for x in p)) for p in SQUARE) + "4 0 1 2 3\n", **PLANE)
    add("concave.off", "OFF\n4 1 0\n0 0 0\n4 2 0\n0 4 0\n3 2 0\n4 0 1 2 3\n", triangles=2, twice_area=(0, 0, 4))
    add("bom.off", "\ufeffOFF\n4 1 0\n" + square + "4 0 1 2 3\n", **PLANE)
    add("vertical_tab.off", ("OFF\n4 1 0\n" + square + "4 0 1 2 3\n").replace(" ", "\x0b"), **PLANE)
    add("more_lines.off", "OFF\n4 1 0\n" + square + "4 0 1 2 3\n\n# end\n2 0 1\nmore\n", **{**PLANE, "notes": ["ignored 2 lines after the last face"]})
    refuse("one_line.off", ("OFF\n4 1 0\n" + square + "4 0 1 2 3\n").replace("\n", " "),
           ":1: more than three counts are in this line; each vertex and face must have a line of its own")
    refuse("word.off", "OFF x\n4 1 0\n" + square + "4 0 1 2 3\n", ":1: 'x' is not a number")
    refuse("keyword.off", "OF\n4 1 0\n", ": does not begin with 'OFF'")
    refuse("dimensions.off", "nOFF\n4\n4 1 0\n", ": 'nOFF' is a kind of OFF that is not read")
    refuse("binary.off", "OFF BINARY\n4 1 0\n", ": binary OFF is not read")
    refuse("cut.off", "OFF\n4 1 0\n" + square, ": is cut off: face 0 of 1 is missing")
    refuse("cut_vertices.off", "OFF\n4 1 0\n0 0 0\n4 0 0\n", ": is cut off: vertex 2 of 4 is missing")
    refuse("giant.off", "OFF\n4294967295 1 0\n0 0 0\n", ": is cut off: 4294967295 vertices do not fit in the 25 bytes of the file")
    refuse("index.off", "OFF\n4 1 0\n" + square + "3 0 1 4\n", ":7: vertex index 4 is out of range; there are 4 vertices")
    refuse("corners.off", "OFF\n4 1 0\n" + square + "4 0 1 2\n", ":7: a number is missing")
    refuse("no_faces.off", "OFF\n4 0 0\n" + square, ": has no faces")


# glTF

COMPONENTS = {"b": 5120, "B": 5121, "h": 5122, "H": 5123, "I": 5125, "f": 5126}


class Gltf:
    """A document that grows; accessors are numbered as they are added."""

    def __init__(self):
        self.data = b""
        self.root = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], "meshes": [], "nodes": [], "scenes": [{"nodes": []}],
                     "scene": 0, "buffers": [{}]}

    def view(self, data, stride=0):
        self.data += b"\0" * (-len(self.data) % 4)
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **({"byteStride": stride} if stride else {})})
        self.data += data
        return len(self.root["bufferViews"]) - 1

    def accessor(self, rows, letter="f", stride=0, **more):
        width = struct.calcsize("<" + str(len(rows[0])) + letter)
        data = b"".join(struct.pack(f"<{len(row)}{letter}", *row).ljust(max(stride, width), b"\0") for row in rows)
        self.root["accessors"].append({"bufferView": self.view(data, stride), "componentType": COMPONENTS[letter], "count": len(rows),
                                       "type": "VEC3" if len(rows[0]) == 3 else "SCALAR", **more})
        return len(self.root["accessors"]) - 1

    def mesh(self, *primitives):
        self.root["meshes"].append({"primitives": list(primitives)})
        return len(self.root["meshes"]) - 1

    def node(self, is_root=True, **node):
        self.root["nodes"].append(node)
        if is_root:
            self.root["scenes"][0]["nodes"].append(len(self.root["nodes"]) - 1)
        return len(self.root["nodes"]) - 1

    def indices(self, values, letter="H"):
        return self.accessor([(v,) for v in values], letter)

    def text(self, **more):
        self.root["buffers"][0] = {"byteLength": len(self.data), "uri": "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()}
        return json.dumps({**self.root, **more})

    def binary(self):
        self.root["buffers"][0] = {"byteLength": len(self.data)}
        text = json.dumps(self.root).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


QUAD = [0, 1, 2, 0, 2, 3]


def quad(index_letter="H", positions=SQUARE, letter="f", stride=0, node=None, primitive=None, indices=QUAD, **more):
    g = Gltf()
    first = {"attributes": {"POSITION": g.accessor(positions, letter, stride, **more)}}
    if indices is not None:
        first["indices"] = g.indices(indices, index_letter)
    g.node(mesh=g.mesh({**first, **(primitive or {})}), **(node or {}))
    return g


def add_gltf():
    for letter in "BHI":
        add(f"indices_{letter}.gltf", quad(letter).text(), **PLANE)
    add("plain.glb", quad().binary(), **PLANE)
    add("glb_in_gltf.gltf", quad().binary(), **PLANE)
    add("bom.gltf", "\ufeff" + quad().text(), **PLANE)
    strip = [SQUARE[0], SQUARE[1], SQUARE[3], SQUARE[2]]
    add("strip.gltf", quad(positions=strip, indices=[0, 1, 2, 3], primitive={"mode": 5}).text(), triangles=2, twice_area=(0, 0, 32), notes=[])
    add("fan.gltf", quad(indices=None, primitive={"mode": 6}).text(), **PLANE)
    add("no_indices.gltf", quad(positions=[SQUARE[i] for i in QUAD], indices=None).text(), vertices=SQUARE, triangles=2, twice_area=(0, 0, 32),
        notes=["welded 6 vertices into 4"])
    add("lines.gltf", quad(indices=[0, 1, 2, 3], primitive={"mode": 1}).text(), triangles=0, edges=2)
    add("loop.gltf", quad(indices=[0, 1, 2, 3], primitive={"mode": 2}).text(), triangles=0, edges=4)
    add("line_strip.gltf", quad(indices=[0, 1, 2, 3], primitive={"mode": 3}).text(), triangles=0, edges=3)
    add("points.gltf", quad(indices=[0, 1, 2, 3], primitive={"mode": 0}).text(), triangles=0, points=4)
    add("stride.gltf", quad(stride=20).text(), **PLANE)
    quantised = {"extensionsRequired": ["KHR_mesh_quantization"], "extensionsUsed": ["KHR_mesh_quantization"]}
    add("int16.gltf", quad(letter="h", stride=8, node={"scale": [.5, .5, .5], "translation": [1, 0, 0]},
                           positions=[(2 * x - 2, 2 * y, 2 * z) for x, y, z in SQUARE]).text(**quantised), **PLANE)
    for letter, one in (("b", 127), ("B", 255), ("h", 32767), ("H", 65535)):
        g = quad(letter=letter, stride=8, node={"scale": [4, 4, 4]}, positions=[(x // 4 * one, y // 4 * one, 0) for x, y, _ in SQUARE], normalized=True)
        add(f"normalised_{letter}.gltf", g.text(**quantised), **PLANE)
    g = quad(positions=[SQUARE[0], SQUARE[1], (9, 9, 9), SQUARE[3]])
    sparse = {"count": 1, "indices": {"bufferView": g.view(struct.pack("<H", 2)), "componentType": 5123},
              "values": {"bufferView": g.view(struct.pack("<3f", *SQUARE[2]))}}
    g.root["accessors"][0]["sparse"] = sparse
    add("sparse.gltf", g.text(), **PLANE)
    g = quad()
    g.root["accessors"][0].pop("bufferView")
    g.root["accessors"][0]["sparse"] = {
        "count": 3, "indices": {"bufferView": g.view(bytes([1, 2, 3])), "componentType": 5121},
        "values": {"bufferView": g.view(b"".join(struct.pack("<3f", *p) for p in SQUARE[1:]))}}
    add("sparse_over_zeros.gltf", g.text(), **PLANE)
    add("matrix.gltf", quad(positions=[(0, 0, 0), (0, 4, 0), (-4, 4, 0), (-4, 0, 0)],  # turned by a quarter about z, and back
                            node={"matrix": [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}).text(), **PLANE)
    add("rotation.gltf", quad(node={"rotation": [1, 0, 0, 0]}).text(), triangles=2, twice_area=(0, 0, -32), vertices=[(x, -y, 0) for x, y, _ in SQUARE])
    add("rotation_of_length_2.gltf", quad(node={"rotation": [2, 0, 0, 0]}).text(), triangles=2, twice_area=(0, 0, -32), vertices=[(x, -y, 0) for x, y, _ in SQUARE])
    add("mirror.gltf", quad(node={"scale": [-1, 1, 1]}).text(), triangles=2, twice_area=(0, 0, 32), vertices=[(-x, y, 0) for x, y, _ in SQUARE])
    g = Gltf()
    mesh = g.mesh({"attributes": {"POSITION": g.accessor(SQUARE)}, "indices": g.indices(QUAD)})
    child = g.node(False, mesh=mesh, translation=[0, 0, 3])
    g.node(children=[child], scale=[2, 2, 2], mesh=mesh)
    add("nested.glb", g.binary(), triangles=4, twice_area=(0, 0, 256), notes=["joined 2 meshes into one"],
        vertices=[(2 * x, 2 * y, 0) for x, y, _ in SQUARE] + [(2 * x, 2 * y, 6) for x, y, _ in SQUARE])
    g = Gltf()
    shared = g.accessor(SQUARE)
    g.node(mesh=g.mesh(*({"attributes": {"POSITION": shared}, "indices": g.indices(part)} for part in (QUAD[:3], QUAD[3:]))))
    add("shared_accessor.glb", g.binary(), **PLANE)
    g = Gltf()
    for at in (0, 8):
        g.node(mesh=g.mesh({"attributes": {"POSITION": g.accessor([(x + at, y, z) for x, y, z in SQUARE])}, "indices": g.indices(QUAD)}))
    add("two_meshes.glb", g.binary(), triangles=4, vertex_count=8, twice_area=(0, 0, 64), notes=["joined 2 meshes into one"])
    g = quad()
    g.root.pop("nodes"), g.root.pop("scenes"), g.root.pop("scene")
    add("no_nodes.gltf", g.text(), **PLANE)
    g = quad()
    g.root.pop("scenes"), g.root.pop("scene")
    add("no_scene.gltf", g.text(), **PLANE)
    g = quad(node={"skin": 0, "translation": [9, 9, 9]}, primitive={"targets": [{}]})
    add("skin.gltf", g.text(skins=[{}]), vertices=SQUARE, triangles=2, notes=["ignored morph targets", "ignored skins: meshes are as they were modelled"])
    add("materials.gltf", quad().text(extensionsRequired=["KHR_materials_unlit"]), **PLANE)

    refuse("draco.gltf", quad().text(extensionsRequired=["KHR_draco_mesh_compression"]), ": requires the extension 'KHR_draco_mesh_compression', which is not read")
    refuse("version.gltf", json.dumps({"asset": {"version": "1.0"}}), ": is glTF of version '1.0'; version 2 is read")
    refuse("cut.gltf", quad().text()[:-1], ": is not a JSON object, or is cut off")
    refuse("cut.glb", quad().binary()[:-1], f": is cut off: it has {len(quad().binary()) - 1} of {len(quad().binary())} bytes")
    refuse("index.gltf", quad(indices=[0, 1, 2, 0, 2, 77]).text(), ": mesh 0: primitive 0: vertex index 77 is out of range; there are 4 vertices")
    refuse("multiple.gltf", quad(indices=QUAD[:4]).text(), ": mesh 0: primitive 0: has 4 indices, which is no multiple of 3")
    refuse("mode.gltf", quad(primitive={"mode": 7}).text(), ": mesh 0: primitive 0: mode 7 is none of glTF's")
    refuse("nan.gltf", quad(positions=[*SQUARE[:3], (0, float("nan"), 0)]).text(), ": accessor 0: position 3 is not finite")
    for name, change, error in (
            ("giant", {"count": 4294967295}, ": accessor 0: is cut off: 4294967295 elements do not fit in 48 bytes"),
            ("giant_64", {"count": 2 ** 63}, f": accessor 0: is cut off: {2 ** 63} elements do not fit in 48 bytes"),
            ("negative", {"count": -1}, ": accessor 0: count must be a whole number"),
            ("component", {"componentType": 7}, ": accessor 0: componentType 7 is none of glTF's"),
            ("type", {"type": "VEC2"}, ": accessor 0: type must be VEC3"),
            ("view", {"bufferView": 9}, ": bufferViews has no element 9; there are 2"),
            ("offset", {"byteOffset": 4}, ": accessor 0: is cut off: 4 elements do not fit in 44 bytes")):
        g = quad()
        g.root["accessors"][0].update(change)
        refuse(f"{name}.gltf", g.text(), error)
    g = quad()
    g.root["accessors"][0].pop("bufferView")
    g.root["accessors"][0]["count"] = 4294967295
    refuse("giant_zeros.gltf", g.text(), ": accessor 0: has 4294967295 elements without data; the limit is 1000000")
    g = quad()
    text = g.text()
    refuse("cut_buffer.gltf", text.replace(f'"buffers": [{{"byteLength": {len(g.data)}', f'"buffers": [{{"byteLength": {len(g.data) + 9}'),
           f": buffer 0: is cut off: it has {len(g.data)} of {len(g.data) + 9} bytes")
    refuse("outside.gltf", json.dumps({**json.loads(text), "buffers": [{"byteLength": 60, "uri": "../secret.bin"}]}),
           ": buffer 0: uri '../secret.bin' is not in the folder of the file")
    refuse("absolute.gltf", json.dumps({**json.loads(text), "buffers": [{"byteLength": 60, "uri": "/etc/passwd"}]}),
           ": buffer 0: uri '/etc/passwd' is not in the folder of the file")
    g = quad()
    g.root["nodes"][0]["children"] = [0]
    refuse("circle.gltf", g.text(), ": node 0: is reached twice; nodes must be trees")
    g = quad()
    for _ in range(300):
        g.node(False, children=[len(g.root["nodes"]) - 1])
    g.root["scenes"][0]["nodes"] = [len(g.root["nodes"]) - 1]
    refuse("deep.gltf", g.text(), ": node 44: nodes are nested deeper than 256")
    g = Gltf()
    mesh = g.mesh({"attributes": {"POSITION": g.accessor(SQUARE)}, "indices": g.indices([i % 4 for i in range(60000)]), "mode": 5})
    for _ in range(200):
        g.node(mesh=mesh)
    expands("many_copies.glb", g.binary())
    g = Gltf()
    first = {"attributes": {"POSITION": g.accessor(SQUARE)}, "indices": g.indices([i % 4 for i in range(6000)])}
    g.node(mesh=g.mesh(*[first] * 1600))
    expands("primitives_share_indices.glb", g.binary())
    g = Gltf()
    first = {"attributes": {"POSITION": g.accessor([(i, 0, 0) for i in range(6000)])}, "mode": 0}
    for _ in range(1600):
        g.node(mesh=g.mesh(first))
    expands("meshes_share_positions.glb", g.binary())
    g = Gltf()
    g.root["accessors"] = [{"componentType": 5126, "count": 1000000, "type": "VEC3"} for _ in range(9)]
    for i in range(9):
        g.node(mesh=g.mesh({"attributes": {"POSITION": i}, "mode": 0}))
    expands("zeros.gltf", g.text())
    g = Gltf()
    g.root["accessors"] = [{"bufferView": 0, "componentType": 5126, "count": 0, "type": "VEC3"}]
    g.view(b"0000")
    mesh = g.mesh(*[{"attributes": {"POSITION": 0}, "mode": 0}] * 5000)
    for _ in range(5000):
        g.node(mesh=mesh)
    refuse("copies_of_nothing.glb", g.binary(), ": has 0 vertices; a mesh needs 3")
    g = quad()
    g.root["accessors"][0]["sparse"] = {"count": 2 ** 63, "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}}
    refuse("giant_sparse.gltf", g.text(), f": accessor 0: sparse has {2 ** 63} elements; the accessor has 4")
    add("minus_zero.gltf", quad().text().replace('"byteOffset": 0', '"byteOffset": -0'), **PLANE)
    add("zero_bytes.gltf", quad().text() + "\0\0", **PLANE)
    refuse("zero_byte.gltf", quad().text().replace(", ", ",\0", 1), ": is not a JSON object, or is cut off")
    refuse("infinite.gltf", quad(node={"scale": [1, 1, 9]}).text().replace("9]", "1" + "0" * 400 + "]"), ": is not a JSON object, or is cut off")
    refuse("empty.gltf", json.dumps({"asset": {"version": "2.0"}}), ": has 0 vertices; a mesh needs 3")
    refuse("list.gltf", "[]", ": is not a JSON object, or is cut off")
    refuse("deep_json.gltf", "[" * 200000, ": is not a JSON object, or is cut off")


# COLLADA

def dae(primitives, node="", positions=SQUARE, nodes=None, count=None, asset=""):
    numbers = " ".join(f"{x} {y} {z}" for x, y, z in positions)
    if nodes is None:
        nodes = f'<node id="n">{node}<instance_geometry url="#g"/></node>'
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}</asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{3 * len(positions)}">{numbers}</float_array><technique_common>
<accessor source="#a" count="{len(positions) if count is None else count}" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
{primitives}
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
"""


def primitive(kind, body, inputs='<input semantic="VERTEX" source="#v" offset="0"/>'):
    return f'<{kind} count="1">{inputs}{body}</{kind}>'


def add_dae():
    triangles = primitive("triangles", "<p>0 1 2 0 2 3</p>")
    add("triangles.dae", dae(triangles), **PLANE)
    add("polylist.dae", dae(primitive("polylist", "<vcount>4</vcount><p>0 1 2 3</p>")), **PLANE)
    add("polygons.dae", dae(primitive("polygons", "<p>0 1 2</p><p>0 2 3</p>")), **PLANE)
    add("tristrips.dae", dae(primitive("tristrips", "<p>0 1 3 2</p>")), triangles=2, twice_area=(0, 0, 32))
    add("trifans.dae", dae(primitive("trifans", "<p>0 1 2 3</p>")), **PLANE)
    add("lines.dae", dae(primitive("lines", "<p>0 1 2 3</p>") + primitive("linestrips", "<p>0 1 2</p>")), triangles=0, edges=4)
    add("concave.dae", dae(primitive("polylist", "<vcount>4</vcount><p>0 1 2 3</p>"), positions=[(0, 0, 0), (4, 2, 0), (0, 4, 0), (3, 2, 0)]),
        triangles=2, twice_area=(0, 0, 4))
    add("offsets.dae", dae(primitive("triangles", "<p>9 0 9 1 9 2 9 0 9 2 9 3</p>", '<input semantic="NORMAL" source="#x" offset="0"/>'
                                     '<input semantic="VERTEX" source="#v" offset="1"/>')), **PLANE)
    add("doubles.dae", dae(primitive("triangles", "<p>0 1 2</p>"), positions=[(.1, 0, 0), (1e-300, 1, 0), (0, 0, 1 / 3)]), triangles=1,
        vertices=[(.1, 0, 0), (1e-300, 1, 0), (0, 0, 1 / 3)])
    add("transforms.dae", dae(triangles, "<translate>1 2 3</translate><scale>2 2 2</scale>"), triangles=2, twice_area=(0, 0, 128),
        vertices=[(2 * x + 1, 2 * y + 2, 3) for x, y, _ in SQUARE])
    add("matrix.dae", dae(triangles, "<matrix>0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1</matrix>"), triangles=2, vertices=[(5 - y, x + 6, 7) for x, y, _ in SQUARE])
    add("mirror.dae", dae(triangles, "<scale>-1 1 1</scale>"), triangles=2, twice_area=(0, 0, 32), vertices=[(-x, y, 0) for x, y, _ in SQUARE])
    add("unit.dae", dae(triangles, asset='<unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis>'), **PLANE)
    add("nested.dae", dae(triangles, nodes='<node id="m"><translate>0 0 2</translate><instance_geometry url="#g"/><node><scale>2 2 2</scale>'
                          '<instance_geometry url="#g"/></node></node><node><translate>0 9 0</translate><instance_node url="#m"/></node>'),
        triangles=8, vertex_count=16, notes=["joined 4 meshes into one"])
    add("no_scene.dae", dae(triangles).replace('<scene><instance_visual_scene url="#s"/></scene>', ""), **PLANE)
    add("library_only.dae", dae(triangles).replace("visual_scene", "other_scene"), **PLANE)
    add("comments.dae", dae(triangles).replace("<p>0 1 2 0", "<p><!-- first -->0 1 2 0").replace("<vertices", "<!-- v --><vertices"), **PLANE)
    skin = '<library_controllers><controller id="c"><skin source="#g"/></controller></library_controllers><library_visual'
    add("skin.dae", dae(triangles, nodes='<node><instance_controller url="#c"/></node>').replace("<library_visual", skin, 1), vertices=SQUARE,
        triangles=2, notes=["ignored skins: meshes are as they were modelled"])
    refuse("index.dae", dae(primitive("triangles", "<p>0 1 4</p>")), ": triangles: vertex index 4 is out of range; there are 4 vertices")
    refuse("multiple.dae", dae(primitive("triangles", "<p>0 1 2 3</p>")), ": triangles: has 4 corners, which is no multiple of 3")
    refuse("holes.dae", dae(primitive("polygons", "<ph><p>0 1 2 3</p><h>0 1 2</h></ph>")), ": polygons: polygons with holes are not read")
    refuse("vcount.dae", dae(primitive("polylist", "<vcount>4 4294967295</vcount><p>0 1 2 3</p>")),
           ": polylist: is cut off: vcount has more corners than p")
    refuse("giant.dae", dae(triangles, count=4294967295), ": source 'p': 4294967295 positions do not fit in 12 numbers")
    refuse("word.dae", dae(triangles).replace("4 4 0", "4 four 0"), ": float_array 'a': 'four' is not a number")
    refuse("nan.dae", dae(triangles).replace("4 4 0", "4 nan 0"), ": source 'p': position 2 is not finite")
    refuse("url.dae", dae(triangles, nodes='<node><instance_geometry url="#other"/></node>'), ": instance_geometry: '#other' is not in the file")
    refuse("skew.dae", dae(triangles, "<skew>1 0 0 0 1 0 0</skew>"), ": node 'n': the transform 'skew' is not read")
    refuse("circle.dae", dae(triangles, nodes='<node id="n"><instance_node url="#n"/></node>'), ": node 'n': nodes are nested deeper than 256")
    bomb = "".join(f'<node id="n{i}"><instance_node url="#n{i + 1}"/><instance_node url="#n{i + 1}"/></node>' for i in range(40))
    expands("bomb.dae", dae(triangles, nodes=bomb + '<node id="n40"/>'))
    expands("bomb_of_a_mesh.dae", dae(triangles, nodes=bomb + '<node id="n40"><instance_geometry url="#g"/></node>'))
    points = [(i, 0, 0) for i in range(6000)]
    geometry = '<geometry id="g{}"><mesh><vertices><input semantic="POSITION" source="#p"/></vertices></mesh></geometry>'
    expands("geometries_share_source.dae", dae("", positions=points, nodes="<node>" + "".join(f'<instance_geometry url="#g{i}"/>' for i in range(1600)) + "</node>")
            .replace("</library_geometries>", "".join(map(geometry.format, range(1600))) + "</library_geometries>"))
    refuse("copies_of_nothing.dae", dae("", positions=points * 5, count=0, nodes="<node>" + '<instance_geometry url="#g"/>' * 20000 + "</node>"),
           ": has 0 vertices; a mesh needs 3")
    chain = "".join(f'<controller id="c{i}"><skin source="#c{i + 1}"/></controller>' for i in range(250)) + '<controller id="c250"><skin source="#g"/></controller>'
    add("controllers.dae", dae(triangles, nodes="<node>" + '<instance_controller url="#c0"/>' * 20000 + "</node>").replace(
        "<library_visual", f"<library_controllers>{chain}</library_controllers><library_visual", 1), triangles=40000, vertex_count=80000,
        notes=["joined 20000 meshes into one", "ignored skins: meshes are as they were modelled"])
    add("comment_in_array.dae", dae(triangles).replace("4 4 0", "4 <!-- four --> 4 <?x y?>0"), **PLANE)
    add("cdata.dae", dae(triangles).replace("<p>0 1 2 0 2 3", "<p><![CDATA[0 1 2]]> 0 2 3"), **PLANE)
    add("bom.dae", "\ufeff" + dae(triangles), **PLANE)
    add("latin_1.dae", dae(triangles, "<!-- \xe9 -->").replace("utf-8", "windows-1252").encode("latin-1"), **PLANE)
    add("prefixes.dae", dae(triangles).replace("xmlns=", "xmlns:c=").replace("<vertices", "<c:vertices").replace("</vertices", "</c:vertices"), **PLANE)
    refuse("not_utf_8.dae", dae(triangles, "<!-- \xe9 -->").encode("latin-1"), ":10: is not well-formed XML, or is cut off")
    refuse("utf_16.dae", dae(triangles).replace("utf-8", "utf-16").encode("utf-16"), ": has bytes of 0; XML must be in UTF-8")
    refuse("ampersand.dae", dae(triangles, "<!-- & --> & "), ":10: is not well-formed XML, or is cut off")
    refuse("attribute_twice.dae", dae(triangles, '<x a="1" a="2"/>'), ":10: is not well-formed XML, or is cut off")
    refuse("minus_zero.dae", dae(primitive("triangles", "<p>-0 1 2</p>")), ": p: '-0' is not a number")
    refuse("no_accessor.dae", dae(triangles).replace("accessor", "access"), ": source 'p': has no accessor")
    refuse("no_skin.dae", dae(triangles, nodes='<node id="c"><instance_controller url="#c"/></node>'), ": node 'c': has no skin and no morph")
    add("large_number_that_is_not_read.dae", dae(triangles).replace("0 4 0</float_array>", "0 4 0 1e999</float_array>"), **PLANE)
    refuse("doctype.dae", dae(triangles).replace("?>\n", '?>\n<!DOCTYPE x [<!ENTITY a "b">]>\n', 1), ": has a DOCTYPE, which COLLADA has not")
    refuse("other.dae", "<html/>", ": has no element COLLADA")
    refuse("deep.dae", dae(triangles, nodes="<node>" * 400 + "</node>" * 400), ": elements are nested deeper than 256")
    refuse("no_faces.dae", dae(""), ": has no faces")


def main(folder):
    for make in (add_obj, add_polygons, add_ply, add_stl, add_off, add_gltf, add_dae):
        make()
    refuse("mesh.fbx", b"", ": the extension must be .obj, .ply, .stl, .off, .gltf, .glb or .dae")
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    names = [name for name, _, _ in ROWS]
    assert len(set(names)) == len(names), sorted(name for name in names if names.count(name) > 1)
    for name, data, _ in ROWS:
        (folder / name).write_bytes(data)
    (folder / "table.json").write_text(json.dumps([{"name": name, **expected} for name, _, expected in ROWS]), encoding="ascii")


if __name__ == "__main__":
    main(sys.argv[1])
