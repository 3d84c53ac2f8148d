from collided.v1 import scene_pb2 as _scene_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

BROAD_PHASE_REASON_COUNTERS: BroadPhaseReason
BROAD_PHASE_REASON_FASTER: BroadPhaseReason
BROAD_PHASE_REASON_FIRST_FRAMES: BroadPhaseReason
BROAD_PHASE_REASON_REQUESTED: BroadPhaseReason
BROAD_PHASE_REASON_TRIAL: BroadPhaseReason
BROAD_PHASE_REASON_UNSPECIFIED: BroadPhaseReason
DESCRIPTOR: _descriptor.FileDescriptor
FRAME_WARNING_INPUT_RESOLUTION: FrameWarning
FRAME_WARNING_UNSPECIFIED: FrameWarning
LIST_USE_MADE: ListUse
LIST_USE_NONE: ListUse
LIST_USE_REUSED: ListUse
LIST_USE_UNSPECIFIED: ListUse
REUSE_REASON_FASTER: ReuseReason
REUSE_REASON_FIRST_FRAMES: ReuseReason
REUSE_REASON_NO_ROOM: ReuseReason
REUSE_REASON_REQUESTED: ReuseReason
REUSE_REASON_SLOWER: ReuseReason
REUSE_REASON_TRIAL: ReuseReason
REUSE_REASON_UNSPECIFIED: ReuseReason
REUSE_REASON_UNSUITED: ReuseReason

class FrameCounts(_message.Message):
    __slots__ = ["base_level", "candidates_edge_edge", "candidates_vertex_triangle", "cells", "contacts_edge_edge", "contacts_edge_triangle", "contacts_triangle_triangle", "contacts_vertex_solid", "contacts_vertex_triangle", "exact_decisions", "inside_out", "leaves", "pairs", "registrations", "survivors_edge_edge", "survivors_vertex_triangle", "tests", "top_level"]
    BASE_LEVEL_FIELD_NUMBER: _ClassVar[int]
    CANDIDATES_EDGE_EDGE_FIELD_NUMBER: _ClassVar[int]
    CANDIDATES_VERTEX_TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    CELLS_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_EDGE_EDGE_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_EDGE_TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_TRIANGLE_TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_VERTEX_SOLID_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_VERTEX_TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    EXACT_DECISIONS_FIELD_NUMBER: _ClassVar[int]
    INSIDE_OUT_FIELD_NUMBER: _ClassVar[int]
    LEAVES_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    REGISTRATIONS_FIELD_NUMBER: _ClassVar[int]
    SURVIVORS_EDGE_EDGE_FIELD_NUMBER: _ClassVar[int]
    SURVIVORS_VERTEX_TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    TESTS_FIELD_NUMBER: _ClassVar[int]
    TOP_LEVEL_FIELD_NUMBER: _ClassVar[int]
    base_level: int
    candidates_edge_edge: int
    candidates_vertex_triangle: int
    cells: int
    contacts_edge_edge: int
    contacts_edge_triangle: int
    contacts_triangle_triangle: int
    contacts_vertex_solid: int
    contacts_vertex_triangle: int
    exact_decisions: int
    inside_out: int
    leaves: int
    pairs: int
    registrations: int
    survivors_edge_edge: int
    survivors_vertex_triangle: int
    tests: int
    top_level: int
    def __init__(self, cells: _Optional[int] = ..., leaves: _Optional[int] = ..., top_level: _Optional[int] = ..., base_level: _Optional[int] = ..., registrations: _Optional[int] = ..., tests: _Optional[int] = ..., pairs: _Optional[int] = ..., candidates_vertex_triangle: _Optional[int] = ..., candidates_edge_edge: _Optional[int] = ..., contacts_vertex_triangle: _Optional[int] = ..., contacts_edge_edge: _Optional[int] = ..., contacts_triangle_triangle: _Optional[int] = ..., survivors_vertex_triangle: _Optional[int] = ..., survivors_edge_edge: _Optional[int] = ..., exact_decisions: _Optional[int] = ..., contacts_edge_triangle: _Optional[int] = ..., contacts_vertex_solid: _Optional[int] = ..., inside_out: _Optional[int] = ...) -> None: ...

class FrameMetrics(_message.Message):
    __slots__ = ["all_pairs_milliseconds", "allocations", "broad_phase_engine", "broad_phase_reason", "bytes_in", "bytes_out", "counts", "decode_milliseconds", "device_bytes", "encode_milliseconds", "engine_milliseconds", "graph_launches", "lbvh_milliseconds", "list_frames", "list_margin", "list_milliseconds", "list_use", "octree_milliseconds", "parts", "queue_milliseconds", "replays", "reuse_reason", "search_milliseconds", "stages", "step_milliseconds", "total_milliseconds", "unused_options", "warnings"]
    ALLOCATIONS_FIELD_NUMBER: _ClassVar[int]
    ALL_PAIRS_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    BROAD_PHASE_ENGINE_FIELD_NUMBER: _ClassVar[int]
    BROAD_PHASE_REASON_FIELD_NUMBER: _ClassVar[int]
    BYTES_IN_FIELD_NUMBER: _ClassVar[int]
    BYTES_OUT_FIELD_NUMBER: _ClassVar[int]
    COUNTS_FIELD_NUMBER: _ClassVar[int]
    DECODE_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    DEVICE_BYTES_FIELD_NUMBER: _ClassVar[int]
    ENCODE_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    ENGINE_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    GRAPH_LAUNCHES_FIELD_NUMBER: _ClassVar[int]
    LBVH_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    LIST_FRAMES_FIELD_NUMBER: _ClassVar[int]
    LIST_MARGIN_FIELD_NUMBER: _ClassVar[int]
    LIST_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    LIST_USE_FIELD_NUMBER: _ClassVar[int]
    OCTREE_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    PARTS_FIELD_NUMBER: _ClassVar[int]
    QUEUE_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    REPLAYS_FIELD_NUMBER: _ClassVar[int]
    REUSE_REASON_FIELD_NUMBER: _ClassVar[int]
    SEARCH_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    STAGES_FIELD_NUMBER: _ClassVar[int]
    STEP_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    TOTAL_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    UNUSED_OPTIONS_FIELD_NUMBER: _ClassVar[int]
    WARNINGS_FIELD_NUMBER: _ClassVar[int]
    all_pairs_milliseconds: float
    allocations: int
    broad_phase_engine: _scene_pb2.BroadPhaseEngine
    broad_phase_reason: BroadPhaseReason
    bytes_in: int
    bytes_out: int
    counts: FrameCounts
    decode_milliseconds: float
    device_bytes: int
    encode_milliseconds: float
    engine_milliseconds: float
    graph_launches: int
    lbvh_milliseconds: float
    list_frames: int
    list_margin: float
    list_milliseconds: float
    list_use: ListUse
    octree_milliseconds: float
    parts: _containers.RepeatedCompositeFieldContainer[PartMetrics]
    queue_milliseconds: float
    replays: int
    reuse_reason: ReuseReason
    search_milliseconds: float
    stages: _containers.RepeatedCompositeFieldContainer[StageTime]
    step_milliseconds: float
    total_milliseconds: float
    unused_options: _containers.RepeatedScalarFieldContainer[str]
    warnings: _containers.RepeatedScalarFieldContainer[FrameWarning]
    def __init__(self, stages: _Optional[_Iterable[_Union[StageTime, _Mapping]]] = ..., counts: _Optional[_Union[FrameCounts, _Mapping]] = ..., total_milliseconds: _Optional[float] = ..., queue_milliseconds: _Optional[float] = ..., device_bytes: _Optional[int] = ..., replays: _Optional[int] = ..., bytes_in: _Optional[int] = ..., bytes_out: _Optional[int] = ..., warnings: _Optional[_Iterable[_Union[FrameWarning, str]]] = ..., step_milliseconds: _Optional[float] = ..., allocations: _Optional[int] = ..., graph_launches: _Optional[int] = ..., broad_phase_engine: _Optional[_Union[_scene_pb2.BroadPhaseEngine, str]] = ..., decode_milliseconds: _Optional[float] = ..., engine_milliseconds: _Optional[float] = ..., encode_milliseconds: _Optional[float] = ..., broad_phase_reason: _Optional[_Union[BroadPhaseReason, str]] = ..., octree_milliseconds: _Optional[float] = ..., lbvh_milliseconds: _Optional[float] = ..., all_pairs_milliseconds: _Optional[float] = ..., list_use: _Optional[_Union[ListUse, str]] = ..., reuse_reason: _Optional[_Union[ReuseReason, str]] = ..., list_margin: _Optional[float] = ..., list_frames: _Optional[int] = ..., list_milliseconds: _Optional[float] = ..., search_milliseconds: _Optional[float] = ..., parts: _Optional[_Iterable[_Union[PartMetrics, _Mapping]]] = ..., unused_options: _Optional[_Iterable[str]] = ...) -> None: ...

class PartMetrics(_message.Message):
    __slots__ = ["contacts", "pairs", "share", "step_milliseconds"]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    SHARE_FIELD_NUMBER: _ClassVar[int]
    STEP_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    contacts: int
    pairs: int
    share: float
    step_milliseconds: float
    def __init__(self, share: _Optional[float] = ..., step_milliseconds: _Optional[float] = ..., pairs: _Optional[int] = ..., contacts: _Optional[int] = ...) -> None: ...

class StageTime(_message.Message):
    __slots__ = ["milliseconds", "stage"]
    MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    STAGE_FIELD_NUMBER: _ClassVar[int]
    milliseconds: float
    stage: str
    def __init__(self, stage: _Optional[str] = ..., milliseconds: _Optional[float] = ...) -> None: ...

class ListUse(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class ReuseReason(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class BroadPhaseReason(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class FrameWarning(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
