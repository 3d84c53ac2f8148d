"""COLLADA (DAE): the geometries that the nodes of the scene place, joined into one mesh. The file's unit and upward axis are
not applied: positions are those that the file has."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from collided.meshes.nodes import IDENTITY, MAX_DEPTH, Expansion, Part, Placer, Transform, product
from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, count_text, fan_faces, fast_numbers, number, strip_faces, vertices_there, whole

_PIECE = 1 << 30  # expat counts bytes in int


def read_dae(data: bytes, _path: str) -> RawMesh:
    if b"<!DOCTYPE" in data:
        raise ReadError("has a DOCTYPE, which COLLADA has not")
    root = _parse(data)
    if _tag(root) != "COLLADA":
        raise ReadError("has no element COLLADA")
    return _Reader(root, Expansion(data)).mesh()


def _parse(data: bytes) -> Element:
    if b"\0" in data:
        raise ReadError("has bytes of 0; XML must be in UTF-8")
    parser = ElementTree.XMLParser(encoding="ISO-8859-1" if _has_other_encoding(data) else None)
    try:
        for at in range(0, len(data), _PIECE):
            parser.feed(data[at:at + _PIECE])
        root: Element = parser.close()
    except ElementTree.ParseError as error:
        raise ReadError("is not well-formed XML, or is cut off", f":{error.position[0]}") from None
    return root


def _has_other_encoding(data: bytes) -> bool:
    """Returns True if the document declares an encoding other than UTF-8. It is then read as Latin-1, byte by byte: only names
    can have characters beyond ASCII, and they are compared with each other alone."""
    declaration = data.split(b"?>", 1)[0] if data.startswith(b"<?xml") else b""
    found = re.search(rb"encoding[^\"']*([\"'])(.*?)(?:\1|$)", declaration, re.DOTALL)
    return found is not None and found[2].lower() != b"utf-8"


def _tag(node: Element) -> str:
    return str(node.tag).rsplit("}", 1)[-1]


def _children(node: Element | None, *tags: str) -> Iterator[Element]:
    return (child for child in (() if node is None else node) if _tag(child) in tags)


def _child(node: Element | None, *path: str) -> Element | None:
    for tag in path:
        node = next(_children(node, tag), None)
    return node


def _place(node: Element) -> str:
    label = node.get("id") or node.get("name")
    return f": {_tag(node)}" + (f" '{label[:80]}'" if label else "")


def _numbers(node: Element | None, kind: type) -> np.ndarray:
    if node is None:
        return np.empty(0, "<f8" if kind is float else np.int64)
    words = (node.text or "").encode().split()
    values = fast_numbers(words, kind)
    if values is None or kind is int and "-" in (node.text or ""):
        values = np.array([number(word, _place(node)) if kind is float else whole(word, _place(node)) for word in words], object)
        return values.astype("<f8") if kind is float else np.minimum(values, 2 ** 62).astype(np.int64)
    return values


def _some(node: Element, count: int) -> list[float]:
    out = _numbers(node, float)
    if len(out) != count:
        raise ReadError(f"has {count_text(len(out), 'number')}; it needs {count}", _place(node))
    if not np.isfinite(out).all():
        raise ReadError("a number is not finite", _place(node))
    return out.tolist()


def _whole(node: Element | None, attribute: str, otherwise: int) -> int:
    value = None if node is None else node.get(attribute)
    if node is None or value is None:
        return otherwise
    return whole(value.encode(), _place(node))


def _rotation(x: float, y: float, z: float, degrees: float) -> Transform:
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0:
        return IDENTITY
    angle = degrees * math.pi / 180
    c, s = math.cos(angle), math.sin(angle)
    t, x, y, z = 1 - c, x / length, y / length, z / length
    return ((t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0.0), (t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0.0),
            (t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0.0))


def _transform(node: Element) -> Transform:
    """The product of a node's transforms, in their order."""
    out = IDENTITY
    for child in node:
        match _tag(child):
            case "matrix":
                rows = _some(child, 16)
                own = tuple(tuple(rows[at:at + 4]) for at in (0, 4, 8))
            case "translate":
                x, y, z = _some(child, 3)
                own = ((1.0, 0.0, 0.0, x), (0.0, 1.0, 0.0, y), (0.0, 0.0, 1.0, z))
            case "scale":
                x, y, z = _some(child, 3)
                own = ((x, 0.0, 0.0, 0.0), (0.0, y, 0.0, 0.0), (0.0, 0.0, z, 0.0))
            case "rotate":
                own = _rotation(*_some(child, 4))
            case "skew" | "lookat":
                raise ReadError(f"the transform '{_tag(child)}' is not read", _place(node))
            case _:
                continue
        out = product(out, own)
    return out


class _Reader:
    def __init__(self, root: Element, expansion: Expansion) -> None:
        self._root = root
        self._ids: dict[str, Element] = {}
        self._expansion, self._placer = expansion, Placer(expansion, welds=False)
        self._nodes: dict[Element, tuple[Transform, list[tuple[bool, Element]]]] = {}
        self._parts: dict[Element, Part] = {}  # of the geometries that were placed
        self._arrays: dict[Element, np.ndarray] = {}
        self._geometries: dict[Element, Element] = {}  # behind controllers
        self._notes: set[str] = set()
        open_nodes = [(root, 0)]
        while open_nodes:
            node, depth = open_nodes.pop()
            if depth > MAX_DEPTH:
                raise ReadError(f"elements are nested deeper than {MAX_DEPTH}")
            if node.get("id") is not None:
                self._ids.setdefault(node.attrib["id"], node)
            open_nodes.extend((child, depth + 1) for child in node)

    def mesh(self) -> RawMesh:
        instance = _child(self._root, "scene", "instance_visual_scene")
        scene = _child(self._root, "library_visual_scenes", "visual_scene") if instance is None else self._target(instance)
        if scene is None:
            for library in _children(self._root, "library_geometries"):
                for geometry in _children(library, "geometry"):
                    self._add(geometry, IDENTITY)
        for node in _children(scene, "node"):
            self._visit(node, IDENTITY, 0)
        mesh = self._placer.mesh()
        mesh.notes += sorted(self._notes)
        return mesh

    def _target(self, reference: Element, attribute: str = "url") -> Element:
        """The element that a reference names."""
        url = reference.get(attribute, "")
        if not url.startswith("#") or url[1:] not in self._ids:
            raise ReadError(f"'{url[:80]}' is not in the file", _place(reference))
        return self._ids[url[1:]]

    def _read(self, node: Element) -> tuple[Transform, list[tuple[bool, Element]]]:
        """The transform of a node, and the nodes (True) and geometries (False) that it places."""
        if node not in self._nodes:  # which may be visited often
            own, items = _transform(node), []
            for child in node:
                match _tag(child):
                    case "node":
                        items.append((True, child))
                    case "instance_node":
                        items.append((True, self._target(child)))
                    case "instance_geometry":
                        items.append((False, self._target(child)))
                    case "instance_controller":
                        items.append((False, self._skinned(self._target(child))))
            self._nodes[node] = own, items
        return self._nodes[node]

    def _visit(self, node: Element, parent: Transform, depth: int) -> None:
        if depth > MAX_DEPTH:
            raise ReadError(f"nodes are nested deeper than {MAX_DEPTH}", _place(node))
        self._expansion.count_node()
        own, items = self._read(node)
        here = parent if own == IDENTITY else product(parent, own)
        for is_node, target in items:
            if is_node:
                self._visit(target, here, depth + 1)
            else:
                self._expansion.count_node()
                self._add(target, here)

    def _skinned(self, controller: Element) -> Element:
        """The geometry behind a controller, as it was modelled."""
        self._notes.add("ignored skins: meshes are as they were modelled")
        path = [controller]
        while path[-1] not in self._geometries:
            skin = _child(path[-1], "skin")
            skin = _child(path[-1], "morph") if skin is None else skin
            if skin is None:
                raise ReadError("has no skin and no morph", _place(path[-1]))
            source = self._target(skin, "source")
            if _tag(source) == "geometry":
                self._geometries[path[-1]] = source
            elif len(path) == MAX_DEPTH:
                raise ReadError("its controllers go in circles", _place(controller))
            else:
                path.append(source)
        geometry = self._geometries[path[-1]]
        self._geometries.update(dict.fromkeys(path, geometry))
        return geometry

    def _add(self, geometry: Element, transform: Transform) -> None:
        mesh = _child(geometry, "mesh")
        if mesh is None:
            self._notes.add("ignored a geometry that is no mesh")
            return
        is_new = geometry not in self._parts
        if is_new:
            self._parts[geometry] = self._part(geometry, mesh)
        self._placer.place(self._parts[geometry], transform, is_new)

    def _part(self, geometry: Element, mesh: Element) -> Part:
        vertices = self._positions(geometry, mesh)
        faces: list[np.ndarray] = []
        edges: list[np.ndarray] = []
        for primitive in mesh:
            _add_primitive(primitive, len(vertices), faces, edges)
        return Part([vertices], faces, edges, [])

    def _array(self, node: Element) -> np.ndarray:
        """The numbers of an array, which several sources may share."""
        if node not in self._arrays:
            self._arrays[node] = _numbers(node, float)
        return self._arrays[node]

    def _positions(self, geometry: Element, mesh: Element) -> np.ndarray:
        inputs = [i for i in _children(_child(mesh, "vertices"), "input") if i.get("semantic") == "POSITION"]
        if not inputs:
            raise ReadError("its vertices have no POSITION", _place(geometry))
        source = self._target(inputs[-1], "source")
        accessor = _child(source, "technique_common", "accessor")
        if accessor is None:
            raise ReadError("has no accessor", _place(source))
        numbers = self._array(self._target(accessor, "source"))
        count, stride, offset = (_whole(accessor, *pair) for pair in (("count", 0), ("stride", 1), ("offset", 0)))
        if stride < 3:
            raise ReadError(f"stride is {stride}; positions need 3", _place(source))
        left = max(len(numbers) - offset, 0)
        if count and (count - 1) * stride + 3 > left:
            raise ReadError(f"{count} positions do not fit in {count_text(left, 'number')}", _place(source))
        self._expansion.count(count)
        positions = numbers[offset + np.arange(count)[:, None] * stride + np.arange(3)] if count else np.empty((0, 3))
        bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
        if bad.size:
            raise ReadError(f"position {bad[0]} is not finite", _place(source))
        return positions


def _vertices_of(primitive: Element, p: Element | None, count: int) -> np.ndarray:
    """Returns the vertex indices among all indices of a primitive."""
    stride, offset = 1, 0
    for input_ in _children(primitive, "input"):
        at = _whole(input_, "offset", 0)
        if at > 255:
            raise ReadError(f"offset is {at}; the limit is 255", _place(input_))
        stride = max(stride, at + 1)
        if input_.get("semantic") == "VERTEX":
            offset = at
    v = _numbers(p, int)[offset::stride]
    bad = np.flatnonzero((v < 0) | (v >= count))
    if bad.size:
        raise ReadError(f"vertex index {v[bad[0]]} is out of range; {vertices_there(count)}",
                        _place(primitive))
    return v


def _add_primitive(node: Element, count: int, faces: list[np.ndarray], edges: list[np.ndarray]) -> None:
    """count: vertices of the mesh."""
    kind = _tag(node)
    if kind == "polylist":
        v, counts = _vertices_of(node, _child(node, "p"), count), _numbers(_child(node, "vcount"), int)
        if (counts < 0).any() or int(counts.astype(object).sum() if counts.size else 0) > len(v):
            raise ReadError("is cut off: vcount has more corners than p", _place(node))
        faces += [face[None] for face in np.split(v, np.cumsum(counts))[:len(counts)]]
    if kind == "polygons" and _child(node, "ph") is not None:
        raise ReadError("polygons with holes are not read", _place(node))
    if kind not in ("triangles", "polygons", "tristrips", "trifans", "lines", "linestrips"):
        return
    for p in _children(node, "p"):
        v = _vertices_of(node, p, count)
        if kind == "triangles" and len(v) % 3:
            raise ReadError(f"has {count_text(len(v), 'corner')}, which is no multiple of 3", _place(node))
        match kind:
            case "triangles":
                faces.append(v.reshape(-1, 3))
            case "polygons":
                faces.append(v[None])
            case "tristrips":
                faces.append(strip_faces(v))
            case "trifans":
                faces.append(fan_faces(v))
            case "lines":
                edges.append(v[:len(v) // 2 * 2].reshape(-1, 2))
            case "linestrips":
                edges.append(np.stack([v[:-1], v[1:]], axis=1))
