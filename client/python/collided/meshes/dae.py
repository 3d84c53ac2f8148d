"""COLLADA (DAE): the geometries that the nodes of the scene place, joined into one mesh. The file's unit and upward axis are
not applied: positions are those that the file has."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from collided.meshes.nodes import IDENTITY, MAX_DEPTH, Part, Placer, product
from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, count_text, fan_faces, number, strip_faces, vertices_there

_MAX_VISITS = 250_000


def read_dae(data: bytes, _path: str) -> RawMesh:
    if b"<!DOCTYPE" in data:
        raise ReadError("has a DOCTYPE, which COLLADA has not")
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        raise ReadError("is not well-formed XML, or is cut off", f":{error.position[0]}") from None
    except (LookupError, ValueError):  # an encoding that is not known
        raise ReadError("is not well-formed XML, or is cut off", ":1") from None
    if _tag(root) != "COLLADA":
        raise ReadError("has no element COLLADA")
    return _Reader(root).mesh()


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
    try:
        if b"_" not in b"".join(words):
            return np.array(words, "S").astype("<f8" if kind is float else np.int64)
    except (ValueError, OverflowError):
        pass
    values = [number(word, _place(node), kind) for word in words]
    return np.array(values, "<f8") if kind is float else np.clip(np.array(values, object), -1, 2 ** 62).astype(np.int64)


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
    whole = number(value.encode(), _place(node), int)
    if whole < 0:
        raise ReadError(f"'{value[:40]}' is not a number", _place(node))
    return whole


def _rotation(x: float, y: float, z: float, degrees: float) -> np.ndarray:
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0:
        return IDENTITY
    angle = degrees * math.pi / 180
    c, s = math.cos(angle), math.sin(angle)
    t, x, y, z = 1 - c, x / length, y / length, z / length
    return np.array([[t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0],
                     [t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0],
                     [t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0], [0, 0, 0, 1]])


def _transform(node: Element) -> np.ndarray:
    """The product of a node's transforms, in their order."""
    out = IDENTITY
    for child in node:
        match _tag(child):
            case "matrix":
                own = np.array(_some(child, 16)).reshape(4, 4)
                own[3] = IDENTITY[3]
            case "translate":
                own = np.eye(4)
                own[:3, 3] = _some(child, 3)
            case "scale":
                own = np.diag([*_some(child, 3), 1.0])
            case "rotate":
                own = _rotation(*_some(child, 4))
            case "skew" | "lookat":
                raise ReadError(f"the transform '{_tag(child)}' is not read", _place(node))
            case _:
                continue
        out = product(out, own)
    return out


class _Reader:
    def __init__(self, root: Element) -> None:
        self._root = root
        self._ids: dict[str, Element] = {}
        self._placer = Placer(welds=False)
        self._notes: set[str] = set()
        self._visits = 0
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

    def _target(self, reference: Element | None, attribute: str = "url") -> Element:
        """The element that a reference names."""
        url = "" if reference is None else reference.get(attribute, "")
        if not url.startswith("#") or url[1:] not in self._ids:
            raise ReadError(f"'{url[:80]}' is not in the file", "" if reference is None else _place(reference))
        return self._ids[url[1:]]

    def _visit(self, node: Element, parent: np.ndarray, depth: int) -> None:
        if depth > MAX_DEPTH:
            raise ReadError(f"nodes are nested deeper than {MAX_DEPTH}", _place(node))
        self._visits += 1
        if self._visits > _MAX_VISITS:
            raise ReadError(f"nodes are instanced more than {_MAX_VISITS} times")
        own = _transform(node)
        here = parent if np.array_equal(own, IDENTITY) else product(parent, own)
        for child in node:
            match _tag(child):
                case "node":
                    self._visit(child, here, depth + 1)
                case "instance_node":
                    self._visit(self._target(child), here, depth + 1)
                case "instance_geometry":
                    self._add(self._target(child), here)
                case "instance_controller":
                    self._add(self._skinned(self._target(child)), here)

    def _skinned(self, controller: Element) -> Element:
        """The geometry behind a controller, as it was modelled."""
        self._notes.add("ignored skins: meshes are as they were modelled")
        for _ in range(MAX_DEPTH):
            controller = self._target(next(_children(controller, "skin", "morph"), None), "source")
            if _tag(controller) == "geometry":
                return controller
        raise ReadError("its controllers go in circles", _place(controller))

    def _add(self, geometry: Element, transform: np.ndarray) -> None:
        mesh = _child(geometry, "mesh")
        if mesh is None:
            self._notes.add("ignored a geometry that is no mesh")
            return
        part = Part([self._positions(geometry, mesh)])
        for primitive in mesh:
            _add_primitive(primitive, part)
        self._placer.place(geometry.get("id", ""), transform, part)

    def _positions(self, geometry: Element, mesh: Element) -> np.ndarray:
        inputs = [i for i in _children(_child(mesh, "vertices"), "input") if i.get("semantic") == "POSITION"]
        if not inputs:
            raise ReadError("its vertices have no POSITION", _place(geometry))
        source = self._target(inputs[-1], "source")
        accessor = _child(source, "technique_common", "accessor")
        numbers = _numbers(self._target(accessor, "source"), float)
        count, stride, offset = (_whole(accessor, *pair) for pair in (("count", 0), ("stride", 1), ("offset", 0)))
        if stride < 3:
            raise ReadError(f"stride is {stride}; positions need 3", _place(source))
        left = max(len(numbers) - offset, 0)
        if count and (count - 1) * stride + 3 > left:
            raise ReadError(f"{count} positions do not fit in {count_text(left, 'number')}", _place(source))
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


def _add_primitive(node: Element, part: Part) -> None:
    kind, count = _tag(node), part.vertex_count
    if kind == "polylist":
        v, counts = _vertices_of(node, _child(node, "p"), count), _numbers(_child(node, "vcount"), int)
        if (counts < 0).any() or int(counts.astype(object).sum() if counts.size else 0) > len(v):
            raise ReadError("is cut off: vcount has more corners than p", _place(node))
        part.faces += [face[None] for face in np.split(v, np.cumsum(counts))[:len(counts)]]
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
                part.faces.append(v.reshape(-1, 3))
            case "polygons":
                part.faces.append(v[None])
            case "tristrips":
                part.faces.append(strip_faces(v))
            case "trifans":
                part.faces.append(fan_faces(v))
            case "lines":
                part.edges.append(v[:len(v) // 2 * 2].reshape(-1, 2))
            case "linestrips":
                part.edges.append(np.stack([v[:-1], v[1:]], axis=1))
