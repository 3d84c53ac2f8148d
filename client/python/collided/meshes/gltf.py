"""glTF 2.0 and GLB: the meshes that the nodes of the scene place, joined into one. Vertices that exporters split for their
normals or texture coordinates are welded within each mesh."""

from __future__ import annotations

import base64
import json
import math
import os
import pathlib
import urllib.parse
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from collided.meshes.nodes import IDENTITY, MAX_DEPTH, Expansion, Part, Placer, Transform, product
from collided.meshes.polygons import ReadError
from collided.meshes.raw import RawMesh, contents, count_text, fan_faces, strip_faces, vertices_there, without_mark

_COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_NORMALISED = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}
_MAX_IMPLICIT = 1_000_000  # zeros that an accessor without data stands for take no bytes in the file
# Other required extensions may change the geometry.
_HARMLESS = ("KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_")


def read_gltf(data: bytes, path: str) -> RawMesh:
    expansion = Expansion(data)
    return _Scene(_Document(data, path, expansion), expansion).mesh()


def _whole(owner: dict[str, Any], key: str, place: str, otherwise: int | None = None) -> int:
    value = owner.get(key, otherwise)
    if type(value) is not int or not 0 <= value < 2 ** 64:
        raise ReadError(f"{key} must be a whole number", place)
    return value


def _base64(uri: str, place: str) -> bytes:
    try:
        text = uri.split(";base64,", 1)[1].rstrip("=")
        return base64.b64decode(text + "=" * (-len(text) % 4), validate=True)
    except (IndexError, ValueError):
        raise ReadError("its data is not base64", place) from None


def _list(owner: dict[str, Any], key: str, place: str) -> list[Any]:
    value = owner.get(key, [])
    if not isinstance(value, list):
        raise ReadError(f"{key} must be an array", place)
    return value


class _Document:
    """The JSON, and the numbers that its accessors describe."""

    def __init__(self, data: bytes, path: str, expansion: Expansion) -> None:
        self._path, self._expansion = path, expansion
        self._binary: bytes | None = None
        self._buffers: dict[int | str, bytes] = {}  # by their number, or the path of their file
        self.root = self._parse(self._open_container(data) if data.startswith(b"glTF") else data)

    def _open_container(self, data: bytes) -> bytes:
        if len(data) < 20:
            raise ReadError("is cut off in its header")
        version, length = (int.from_bytes(data[i:i + 4], "little") for i in (4, 8))
        if version != 2:
            raise ReadError(f"is GLB of version {version}; version 2 is read")
        if length > len(data):
            raise ReadError(f"is cut off: it has {len(data)} of {length} bytes")
        text, at = None, 12
        while len(data) - at >= 8:
            length, kind = int.from_bytes(data[at:at + 4], "little"), data[at + 4:at + 8]
            if length > len(data) - at - 8:
                raise ReadError(f"is cut off within a chunk of {count_text(length, 'byte')}")
            chunk = data[at + 8:at + 8 + length]
            if kind == b"JSON" and text is None:
                text = chunk
            if kind == b"BIN\0" and self._binary is None:
                self._binary = chunk
            at += 8 + length + (4 - length % 4) % 4
        if not text:
            raise ReadError("has no JSON chunk")
        return text

    def _parse(self, text: bytes) -> dict[str, Any]:
        try:
            text = without_mark(text).rstrip(b"\0")  # some exporters pad with it
            root = json.loads(text.decode(), parse_constant=_refuse_constant, parse_int=_parse_int, parse_float=_parse_float)
            if b"\\u" in text:
                json.dumps(root, ensure_ascii=False).encode()  # which refuses half of a surrogate pair
        except (ValueError, RecursionError):
            root = None
        if not isinstance(root, dict):
            raise ReadError("is not a JSON object, or is cut off")
        asset = root.get("asset")
        version = asset.get("version") if isinstance(asset, dict) else ""
        if not isinstance(version, str) or not version.startswith("2."):
            raise ReadError(f"is glTF of version '{version if isinstance(version, str) else ''}'; version 2 is read")
        for required in _list(root, "extensionsRequired", ""):
            if not str(required).startswith(_HARMLESS):
                raise ReadError(f"requires the extension '{str(required)[:80]}', which is not read")
        return root

    def element(self, array: str, index: int) -> dict[str, Any]:
        elements = _list(self.root, array, "")
        if index >= len(elements):
            raise ReadError(f"{array} has no element {index}; there are {len(elements)}")
        if not isinstance(elements[index], dict):
            raise ReadError("must be an object", f": {array} {index}")
        return elements[index]

    def _load(self, spec: dict[str, Any], index: int, place: str) -> bytes:
        uri = spec.get("uri")
        if not isinstance(uri, str):
            raise ReadError("has no data", place)
        if uri.startswith("data:"):
            if index not in self._buffers:
                self._buffers[index] = _base64(uri, place)
            return self._buffers[index]
        # A file from a stranger must not make the reader open files elsewhere.
        name = pathlib.PurePath(urllib.parse.unquote(uri))
        if "://" in uri or name.is_absolute() or ".." in name.parts:
            raise ReadError(f"uri '{uri[:80]}' is not in the folder of the file", place)
        file = os.fspath(pathlib.Path(self._path).parent / name)
        if file in self._buffers:  # buffers can name one file many times
            return self._buffers[file]
        try:
            data = self._buffers[file] = contents(file)
        except OSError as error:
            raise ReadError(f"{file}: {error.strerror}", place) from None
        self._expansion.bytes += len(data)
        return data

    def _buffer(self, index: int) -> memoryview:
        spec, place = self.element("buffers", index), f": buffer {index}"
        length = _whole(spec, "byteLength", place)
        if index == 0 and self._binary is not None and "uri" not in spec:
            data = self._binary
        else:
            data = self._load(spec, index, place)
        if len(data) < length:
            raise ReadError(f"is cut off: it has {len(data)} of {length} bytes", place)
        return memoryview(data)[:length]

    def _view(self, index: int) -> memoryview:
        spec, place = self.element("bufferViews", index), f": bufferView {index}"
        data = self._buffer(_whole(spec, "buffer", place))
        offset, length = _whole(spec, "byteOffset", place, 0), _whole(spec, "byteLength", place)
        if offset + length > len(data):
            raise ReadError(f"is cut off: {count_text(length, 'byte')} from {offset} on do not fit in a buffer of {len(data)}",
                            place)
        return data[offset:offset + length]

    def _unpack(self, data: memoryview, offset: int, stride: int, count: int, components: int, kind: int, place: str,
                counts_as: int) -> np.ndarray:
        """Numbers of `count` elements in the bytes from `offset` on, each of which counts as `counts_as`."""
        if kind not in _COMPONENTS:
            raise ReadError(f"componentType {kind} is none of glTF's", place)
        dtype = np.dtype(_COMPONENTS[kind])
        element = dtype.itemsize * components
        stride = stride or element
        if stride < element:
            raise ReadError(f"byteStride {stride} is less than an element", place)
        left = max(len(data) - offset, 0)
        if count and (count - 1) * stride + element > left:
            raise ReadError(f"is cut off: {count_text(count, 'element')} do not fit in {count_text(left, 'byte')}", place)
        self._expansion.count(counts_as * count)
        if not count:
            return np.empty((0, components), dtype)
        return np.ndarray((count, components), dtype, data, offset, (stride, dtype.itemsize)).copy()

    def _numbers(self, index: int, kind: str, components: int, counts_as: int) -> np.ndarray:
        spec, place = self.element("accessors", index), f": accessor {index}"
        if spec.get("type") != kind:
            raise ReadError(f"type must be {kind}", place)
        count, component = _whole(spec, "count", place), _whole(spec, "componentType", place)
        if "bufferView" in spec:
            view = _whole(spec, "bufferView", place)
            stride = _whole(self.element("bufferViews", view), "byteStride", place, 0)
            out = self._unpack(self._view(view), _whole(spec, "byteOffset", place, 0), stride, count, components, component, place,
                               counts_as)
        else:
            if count > _MAX_IMPLICIT:
                raise ReadError(f"has {count} elements without data; the limit is {_MAX_IMPLICIT}", place)
            if component not in _COMPONENTS:
                raise ReadError(f"componentType {component} is none of glTF's", place)
            self._expansion.count(counts_as * count)
            out = np.zeros((count, components), _COMPONENTS[component])
        if "sparse" in spec:
            self._add_sparse(spec, components, out, place)
        if spec.get("normalized") is True and component in _NORMALISED:
            out = np.maximum(out / np.float64(_NORMALISED[component]), -1.0)
        return out

    def _add_sparse(self, spec: dict[str, Any], components: int, out: np.ndarray, place: str) -> None:
        sparse = spec["sparse"]
        where, what = (sparse.get("indices"), sparse.get("values")) if isinstance(sparse, dict) else (None, None)
        if not isinstance(where, dict) or not isinstance(what, dict):
            raise ReadError("sparse must have indices and values", place)
        count = _whole(sparse, "count", place)
        if count > len(out):
            raise ReadError(f"sparse has {count_text(count, 'element')}; the accessor has {len(out)}", place)
        indices = self._unpack(self._view(_whole(where, "bufferView", place)), _whole(where, "byteOffset", place, 0), 0, count, 1,
                               _whole(where, "componentType", place), place + ": sparse indices", 0)[:, 0]
        values = self._unpack(self._view(_whole(what, "bufferView", place)), _whole(what, "byteOffset", place, 0), 0, count,
                              components, _whole(spec, "componentType", place), place + ": sparse values", 0)
        if not ((indices >= 0) & (indices < len(out))).all():
            raise ReadError(f"a sparse index is out of range; there are {count_text(len(out), 'element')}", place)
        out[indices.astype(np.int64)] = values

    def positions(self, index: int) -> np.ndarray:
        out = self._numbers(index, "VEC3", 3, 1)
        bad = np.flatnonzero(~np.isfinite(out).all(axis=1))
        if bad.size:
            raise ReadError(f"position {bad[0]} is not finite", f": accessor {index}")
        return out if out.dtype.kind == "f" else out.astype("<f8")

    def indices(self, index: int, corners_each: int) -> np.ndarray:
        """corners_each: the corners that one index can make, which are counted."""
        place = f": accessor {index}"
        if _whole(self.element("accessors", index), "componentType", place) not in (5121, 5123, 5125):
            raise ReadError("componentType of indices must be 5121, 5123 or 5125", place)
        return self._numbers(index, "SCALAR", 1, corners_each)[:, 0].astype(np.int64)


def _refuse_constant(_: str) -> None:
    raise ValueError  # NaN and Infinity are no JSON


def _parse_float(word: str) -> float:
    value = float(word)
    if value - value != 0:
        raise ValueError
    return value


def _parse_int(word: str) -> int | float:
    return int(word) if len(word) <= 20 else _parse_float(word)


@dataclass
class _Growing:
    """Collects the arrays of a mesh, primitive by primitive."""

    vertices: list[np.ndarray] = field(default_factory=list)
    vertex_count: int = 0
    known: dict[int, tuple[int, int]] = field(default_factory=dict)  # first vertex and count of accessors, which primitives may share
    faces: list[np.ndarray] = field(default_factory=list)
    edges: list[np.ndarray] = field(default_factory=list)
    points: list[np.ndarray] = field(default_factory=list)


class _Scene:
    """The nodes."""

    def __init__(self, document: _Document, expansion: Expansion) -> None:
        self._document, self._expansion = document, expansion
        self._placer = Placer(expansion, welds=True)
        self._parts: dict[int, Part] = {}  # of the meshes that were placed
        self._node_count = len(_list(document.root, "nodes", ""))
        self._visited: set[int] = set()
        self._ignored: set[str] = set()

    def mesh(self) -> RawMesh:
        for root in self._roots():
            self._visit(root, IDENTITY, 0)
        if not self._node_count:  # a library of meshes that no node places
            for mesh in range(len(_list(self._document.root, "meshes", ""))):
                self._place(mesh, IDENTITY)
        made = self._placer.mesh()
        made.notes += [f"ignored {what}" for what in sorted(self._ignored)]
        return made

    def _roots(self) -> list[int]:
        """Returns the nodes of the default scene. Without any scene these are all nodes without a parent."""
        if _list(self._document.root, "scenes", ""):
            scene = _whole(self._document.root, "scene", "", 0)
            return self._indices(self._document.element("scenes", scene), "nodes", f": scene {scene}")
        children = {child for node in range(self._node_count) for child in self._children(node)}
        return [node for node in range(self._node_count) if node not in children]

    @staticmethod
    def _indices(owner: dict[str, Any], key: str, place: str) -> list[int]:
        values = _list(owner, key, place)
        if any(type(value) is not int or value < 0 for value in values):
            raise ReadError("must list whole numbers", f"{place}: {key}")
        return values

    def _children(self, node: int) -> list[int]:
        return self._indices(self._document.element("nodes", node), "children", f": node {node}")

    def _visit(self, node: int, parent: Transform, depth: int) -> None:
        spec, place = self._document.element("nodes", node), f": node {node}"
        if node in self._visited:
            raise ReadError("is reached twice; nodes must be trees", place)
        self._visited.add(node)
        if depth == MAX_DEPTH:
            raise ReadError(f"nodes are nested deeper than {MAX_DEPTH}", place)
        own = _transform(spec, place)
        here = parent if own == IDENTITY else product(parent, own)
        if "skin" in spec:
            self._ignored.add("skins: meshes are as they were modelled")
        if "mesh" in spec:  # a skin replaces its node's transform
            self._place(_whole(spec, "mesh", place), IDENTITY if "skin" in spec else here)
        for child in self._children(node):
            self._visit(child, here, depth + 1)

    def _place(self, mesh: int, transform: Transform) -> None:
        is_new = mesh not in self._parts
        if is_new:
            self._parts[mesh] = self._read_part(mesh)
        self._placer.place(self._parts[mesh], transform, is_new)

    def _read_part(self, mesh: int) -> Part:
        growing = _Growing()
        for number, primitive in enumerate(_list(self._document.element("meshes", mesh), "primitives", f": mesh {mesh}")):
            place = f": mesh {mesh}: primitive {number}"
            if not isinstance(primitive, dict):
                raise ReadError("must be an object", place)
            self._add_primitive(growing, primitive, place)
        return Part(growing.vertices, growing.faces, growing.edges, growing.points)

    def _add_primitive(self, part: _Growing, primitive: dict[str, Any], place: str) -> None:
        attributes = primitive.get("attributes")
        if not isinstance(attributes, dict):
            raise ReadError("attributes must be an object", place)
        if "targets" in primitive:
            self._ignored.add("morph targets")
        accessor = _whole(attributes, "POSITION", place)
        if accessor not in part.known:
            vertices = self._document.positions(accessor)
            part.known[accessor] = (part.vertex_count, len(vertices))
            part.vertices.append(vertices)
            part.vertex_count += len(vertices)
        start, count = part.known[accessor]
        mode = _whole(primitive, "mode", place, 4)
        corners_each = {2: 2, 3: 2, 5: 3, 6: 3}.get(mode, 1)
        if "indices" in primitive:
            indices = self._document.indices(_whole(primitive, "indices", place), corners_each)
        else:
            self._expansion.count(corners_each * count)
            indices = np.arange(count)
        bad = np.flatnonzero(indices >= count)
        if bad.size:
            raise ReadError(f"vertex index {indices[bad[0]]} is out of range; {vertices_there(count)}",
                            place)
        _add_elements(part, mode, indices + start, place)


def _add_elements(part: _Growing, mode: int, v: np.ndarray, place: str) -> None:
    def rows_of(columns: int) -> np.ndarray:
        if len(v) % columns:
            raise ReadError(f"has {count_text(len(v), 'index', 'indices')}, which is no multiple of {columns}", place)
        return v.reshape(-1, columns)

    if mode == 0:
        part.points.append(v)
    elif mode == 1:
        part.edges.append(rows_of(2))
    elif mode in (2, 3):
        part.edges.append(np.stack([v[:-1], v[1:]], axis=1))
        if mode == 2 and len(v) > 2:
            part.edges.append(v[[-1, 0]][None])
    elif mode == 4:
        part.faces.append(rows_of(3))
    elif mode in (5, 6):
        part.faces.append(strip_faces(v) if mode == 5 else fan_faces(v))
    else:
        raise ReadError(f"mode {mode} is none of glTF's", place)


def _numbers(node: dict[str, Any], key: str, otherwise: list[float], place: str) -> list[float]:
    values = node.get(key, otherwise)
    is_fine = isinstance(values, list) and len(values) == len(otherwise) and all(type(x) in (int, float) for x in values)
    if not is_fine or not all(map(math.isfinite, values)):
        raise ReadError(f"{key} must be {len(otherwise)} numbers", place)
    return [float(x) for x in values]


def _transform(node: dict[str, Any], place: str) -> Transform:
    if "matrix" in node:
        columns = _numbers(node, "matrix", [0.0] * 16, place)
        return tuple(tuple(columns[row::4]) for row in range(3))
    t = _numbers(node, "translation", [0.0] * 3, place)
    x, y, z, w = _numbers(node, "rotation", [0.0, 0.0, 0.0, 1.0], place)
    s = _numbers(node, "scale", [1.0] * 3, place)
    squared = x * x + y * y + z * z + w * w  # exporters round, so that it is not quite 1
    if not 0 < squared < float("inf"):
        raise ReadError("'rotation' is no quaternion: its length is 0, or infinite", place)
    n = 2 / squared
    return ((1 - n * (y * y + z * z)) * s[0], n * (x * y - z * w) * s[1], n * (x * z + y * w) * s[2], t[0]), \
           (n * (x * y + z * w) * s[0], (1 - n * (x * x + z * z)) * s[1], n * (y * z - x * w) * s[2], t[1]), \
           (n * (x * z - y * w) * s[0], n * (y * z + x * w) * s[1], (1 - n * (x * x + y * y)) * s[2], t[2])
