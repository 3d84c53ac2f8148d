"""What a scene asks for: everything of its spec but its meshes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from collided.arrays import check_length, is_whole, real
from collided.choices import check_text, choice, word
from collided.columns import COLUMNS
from collided.errors import InvalidArgument
from collided.kinds import KINDS
from collided.layout import Layout
from collided.positions import Box, Format, format_named
from collided.v1 import contact_pb2, scene_pb2

FIELDS = tuple(column.field for column in COLUMNS.values())
_SHORT_KINDS = {kind.short: kind.name for kind in KINDS.values()}


@dataclass(frozen=True, kw_only=True)
class SceneOptions:
    """Options of a scene. Lengths are in the unit of the positions. What goes together only the daemon decides.

    mode: "ccd" (what touches on the way to a frame's positions), "dcd" (what is near there), or "dcd_and_ccd", where
        each frame says which.
    accuracy: "candidates", "fast", "guarded", "certified" or "exact"; None: the daemon's default, "certified".
    position_format: "f32", "f64" or "q16"; None: "f32" if all meshes have float32 vertices, else "f64".
    quantization_box: the Box of "q16".
    thickness, delta, min_separation, rest_distance: lengths >= 0. To `thickness` meshes add their own `half_thickness`; a
        `rest_distance` of 0 is each mesh's own contact distance.
    kinds: of "vt", "ee", "tt" and, in frames of DCD, "et" (edges that go through triangles) and "vs" (vertices in solids); empty: the
        first two.
    fields: of FIELDS, and "pair_states" (`Contacts.pairs`); those that are left out are neither computed nor sent. All of FIELDS mean
        all that the daemon knows, and, where some mesh is a solid, "pair_states" in frames of DCD.
    report: "all", "earliest_only" or "any_hit".
    backend: "auto", "cpu" or "cuda".
    device: id of the device that the scene is to live on, such as "cuda:1"; None: the daemon places it.
    part_devices: ids of the devices that it is to be spread over instead, a part on each; pays in large scenes alone.
    broad_phase: an engine, such as "octree" or "lbvh"; None: the daemon chooses.
    reuse: "on" or "off": whether frames that resemble the last reuse its list of neighbours; None: where it is faster.
    memory_budget: bytes that the scene may hold; 0: the daemon's limit.
    expected_contacts: contacts of a frame that room is made for at once, at most 2^32 - 1; 0: for few.
    exclude: pairs of meshes that are not tested.
    display_name: for people, at most 128 bytes.
    """

    mode: str = "ccd"
    accuracy: str | None = None
    position_format: str | None = None
    quantization_box: Box | None = None
    thickness: float = 0.0
    delta: float = 0.0
    min_separation: float = 0.0
    rest_distance: float = 0.0
    kinds: Iterable[str] = ()
    fields: Iterable[str] = FIELDS
    report: str | None = None
    backend: str | None = None
    device: str | None = None
    part_devices: Iterable[str] = ()
    broad_phase: str | None = None
    reuse: str | None = None
    memory_budget: int = 0
    expected_contacts: int = 0
    exclude: Iterable[tuple[str | int, str | int]] = ()
    display_name: str = ""

    def __post_init__(self) -> None:
        for name in ("thickness", "delta", "min_separation", "rest_distance"):
            check_length(getattr(self, name), name)
        _check_count(self.memory_budget, "memory_budget", 64)
        _check_count(self.expected_contacts, "expected_contacts", 32)
        mode = choice(scene_pb2.DetectionMode, "DETECTION_MODE_", self.mode, "mode")
        object.__setattr__(self, "mode", word(scene_pb2.DetectionMode, "DETECTION_MODE_", mode))
        for name in ("exclude", "part_devices", "kinds", "fields"):
            object.__setattr__(self, name, tuple(words(getattr(self, name), name)))
        check_text(self.display_name, "display_name")
        if self.device is not None:
            check_text(self.device, "device")
        for device in self.part_devices:
            check_text(device, "part_devices")
        if not isinstance(self.quantization_box, (Box, type(None))):
            raise InvalidArgument(f"quantization_box is {self.quantization_box!r}; it must be a Box", field="quantization_box")
        self.spec()

    def format(self, layout: Layout) -> Format:
        """The format of all positions."""
        name = word(scene_pb2.PositionFormat, "POSITION_FORMAT_",
                    choice(scene_pb2.PositionFormat, "POSITION_FORMAT_", self.position_format or _natural(layout),
                           "position_format"))
        return format_named(name, self.quantization_box)

    @property
    def has_all_fields(self) -> bool:
        """Returns True if `fields` are FIELDS, the default."""
        return set(self.fields) == set(FIELDS)

    def spec(self) -> scene_pb2.SceneSpec:
        """The spec without meshes, and without what depends on them."""
        spec = scene_pb2.SceneSpec(
            display_name=self.display_name, thickness=self.thickness, delta=self.delta,
            min_separation=self.min_separation, rest_distance=self.rest_distance, memory_budget_bytes=self.memory_budget,
            expected_contacts=self.expected_contacts, device=self.device, part_devices=self.part_devices,
            mode=choice(scene_pb2.DetectionMode, "DETECTION_MODE_", self.mode, "mode"),
            accuracy=choice(scene_pb2.Accuracy, "ACCURACY_", self.accuracy, "accuracy"),
            report=choice(scene_pb2.Report, "REPORT_", self.report, "report"),
            backend=choice(scene_pb2.Backend, "BACKEND_", self.backend, "backend"),
            broad_phase_engine=choice(scene_pb2.BroadPhaseEngine, "BROAD_PHASE_ENGINE_", self.broad_phase, "broad_phase"),
            reuse=choice(scene_pb2.Reuse, "REUSE_", self.reuse, "reuse"),
            kinds=[choice(contact_pb2.ContactKind, "CONTACT_KIND_",
                          _SHORT_KINDS.get(kind, kind) if isinstance(kind, str) else kind, "kinds")
                   for kind in self.kinds],
            fields=[choice(contact_pb2.ContactField, "CONTACT_FIELD_", name, "fields")
                    for name in self.fields])
        if self.quantization_box is not None:
            spec.quantization_box.lower.extend(self.quantization_box.lower)
            spec.quantization_box.upper.extend(self.quantization_box.upper)
        return spec


def words(values: Any, argument: str) -> list[Any]:
    """A list, which a single word is not."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise InvalidArgument(f"{argument} is {values!r}; it must be a list, such as [{values!r}]", field=argument)
    return list(values)


def _check_count(value: Any, argument: str, bits: int) -> None:
    if not is_whole(value, 2**bits - 1):
        raise InvalidArgument(f"{argument} is {value!r}; it must be from 0 to 2^{bits} - 1", field=argument)


def check_seconds(value: Any, argument: str) -> None:
    """Whether it is a time to wait: at least 0, perhaps without an end."""
    if not real(value) >= 0:
        raise InvalidArgument(f"{argument} is {value!r}; it must be seconds, at least 0", field=argument)


def _natural(layout: Layout) -> str:
    """The format that rounds nothing."""
    arrays = [mesh.vertices for _, mesh in layout.present()]
    is_single = all(a is not None and a.dtype in (np.dtype("<f4"), np.dtype("<f2")) for a in arrays)
    return "f32" if is_single else "f64"
