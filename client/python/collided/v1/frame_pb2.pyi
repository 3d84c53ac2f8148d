from collided.v1 import added_in_pb2 as _added_in_pb2
from collided.v1 import contact_pb2 as _contact_pb2
from collided.v1 import metrics_pb2 as _metrics_pb2
from collided.v1 import scene_pb2 as _scene_pb2
from collided.v1 import shared_range_pb2 as _shared_range_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

ADVANCE_MODE_ALL_OR_ONE: AdvanceMode
ADVANCE_MODE_PER_MESH: AdvanceMode
ADVANCE_MODE_PER_VERTEX: AdvanceMode
ADVANCE_MODE_UNSPECIFIED: AdvanceMode
DESCRIPTOR: _descriptor.FileDescriptor

class Frame(_message.Message):
    __slots__ = ["accuracy", "advance", "advance_mode", "delta", "edit", "frame_id", "from_last_fraction", "ignore_separating", "limits", "meshes", "mode", "report", "trial", "updates", "worlds"]
    ACCURACY_FIELD_NUMBER: _ClassVar[int]
    ADVANCE_FIELD_NUMBER: _ClassVar[int]
    ADVANCE_MODE_FIELD_NUMBER: _ClassVar[int]
    DELTA_FIELD_NUMBER: _ClassVar[int]
    EDIT_FIELD_NUMBER: _ClassVar[int]
    FRAME_ID_FIELD_NUMBER: _ClassVar[int]
    FROM_LAST_FRACTION_FIELD_NUMBER: _ClassVar[int]
    IGNORE_SEPARATING_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    MESHES_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    REPORT_FIELD_NUMBER: _ClassVar[int]
    TRIAL_FIELD_NUMBER: _ClassVar[int]
    UPDATES_FIELD_NUMBER: _ClassVar[int]
    WORLDS_FIELD_NUMBER: _ClassVar[int]
    accuracy: _scene_pb2.Accuracy
    advance: bool
    advance_mode: AdvanceMode
    delta: float
    edit: _scene_pb2.SceneEdit
    frame_id: int
    from_last_fraction: float
    ignore_separating: bool
    limits: bool
    meshes: _containers.RepeatedScalarFieldContainer[int]
    mode: _scene_pb2.DetectionMode
    report: _scene_pb2.Report
    trial: bool
    updates: _containers.RepeatedCompositeFieldContainer[MeshUpdate]
    worlds: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, frame_id: _Optional[int] = ..., accuracy: _Optional[_Union[_scene_pb2.Accuracy, str]] = ..., updates: _Optional[_Iterable[_Union[MeshUpdate, _Mapping]]] = ..., delta: _Optional[float] = ..., report: _Optional[_Union[_scene_pb2.Report, str]] = ..., ignore_separating: bool = ..., advance: bool = ..., trial: bool = ..., from_last_fraction: _Optional[float] = ..., mode: _Optional[_Union[_scene_pb2.DetectionMode, str]] = ..., edit: _Optional[_Union[_scene_pb2.SceneEdit, _Mapping]] = ..., worlds: _Optional[_Iterable[int]] = ..., meshes: _Optional[_Iterable[int]] = ..., advance_mode: _Optional[_Union[AdvanceMode, str]] = ..., limits: bool = ...) -> None: ...

class FrameDone(_message.Message):
    __slots__ = ["advanced", "any_contact", "contact_count", "contacts", "earliest_toi", "limits", "metrics", "pairs", "shortened", "way"]
    ADVANCED_FIELD_NUMBER: _ClassVar[int]
    ANY_CONTACT_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    CONTACT_COUNT_FIELD_NUMBER: _ClassVar[int]
    EARLIEST_TOI_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    METRICS_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    SHORTENED_FIELD_NUMBER: _ClassVar[int]
    WAY_FIELD_NUMBER: _ClassVar[int]
    advanced: float
    any_contact: bool
    contact_count: int
    contacts: _containers.RepeatedCompositeFieldContainer[_contact_pb2.ContactChunk]
    earliest_toi: float
    limits: _containers.RepeatedCompositeFieldContainer[_contact_pb2.ContactChunk]
    metrics: _metrics_pb2.FrameMetrics
    pairs: _contact_pb2.MeshPairs
    shortened: ShortenedWays
    way: float
    def __init__(self, metrics: _Optional[_Union[_metrics_pb2.FrameMetrics, _Mapping]] = ..., contact_count: _Optional[int] = ..., earliest_toi: _Optional[float] = ..., any_contact: bool = ..., contacts: _Optional[_Iterable[_Union[_contact_pb2.ContactChunk, _Mapping]]] = ..., advanced: _Optional[float] = ..., pairs: _Optional[_Union[_contact_pb2.MeshPairs, _Mapping]] = ..., way: _Optional[float] = ..., shortened: _Optional[_Union[ShortenedWays, _Mapping]] = ..., limits: _Optional[_Iterable[_Union[_contact_pb2.ContactChunk, _Mapping]]] = ...) -> None: ...

class FrameError(_message.Message):
    __slots__ = ["code", "field", "message", "retry_after_seconds"]
    CODE_FIELD_NUMBER: _ClassVar[int]
    FIELD_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    RETRY_AFTER_SECONDS_FIELD_NUMBER: _ClassVar[int]
    code: int
    field: str
    message: str
    retry_after_seconds: float
    def __init__(self, code: _Optional[int] = ..., message: _Optional[str] = ..., field: _Optional[str] = ..., retry_after_seconds: _Optional[float] = ...) -> None: ...

class MeshUpdate(_message.Message):
    __slots__ = ["mesh", "positions", "rigid", "shared_positions", "shared_start_positions", "sparse", "start_positions"]
    MESH_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    RIGID_FIELD_NUMBER: _ClassVar[int]
    SHARED_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    SHARED_START_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    SPARSE_FIELD_NUMBER: _ClassVar[int]
    START_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    mesh: int
    positions: bytes
    rigid: RigidTransform
    shared_positions: _shared_range_pb2.SharedRange
    shared_start_positions: _shared_range_pb2.SharedRange
    sparse: SparseIndices
    start_positions: bytes
    def __init__(self, mesh: _Optional[int] = ..., sparse: _Optional[_Union[SparseIndices, _Mapping]] = ..., rigid: _Optional[_Union[RigidTransform, _Mapping]] = ..., start_positions: _Optional[bytes] = ..., positions: _Optional[bytes] = ..., shared_positions: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., shared_start_positions: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ...) -> None: ...

class RigidTransform(_message.Message):
    __slots__ = ["matrix", "start_matrix"]
    MATRIX_FIELD_NUMBER: _ClassVar[int]
    START_MATRIX_FIELD_NUMBER: _ClassVar[int]
    matrix: bytes
    start_matrix: bytes
    def __init__(self, matrix: _Optional[bytes] = ..., start_matrix: _Optional[bytes] = ...) -> None: ...

class ShortenedWays(_message.Message):
    __slots__ = ["fractions", "ids"]
    FRACTIONS_FIELD_NUMBER: _ClassVar[int]
    IDS_FIELD_NUMBER: _ClassVar[int]
    fractions: bytes
    ids: bytes
    def __init__(self, ids: _Optional[bytes] = ..., fractions: _Optional[bytes] = ...) -> None: ...

class SparseIndices(_message.Message):
    __slots__ = ["indices", "shared_indices"]
    INDICES_FIELD_NUMBER: _ClassVar[int]
    SHARED_INDICES_FIELD_NUMBER: _ClassVar[int]
    indices: bytes
    shared_indices: _shared_range_pb2.SharedRange
    def __init__(self, indices: _Optional[bytes] = ..., shared_indices: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ...) -> None: ...

class WorldError(_message.Message):
    __slots__ = ["error", "world"]
    ERROR_FIELD_NUMBER: _ClassVar[int]
    WORLD_FIELD_NUMBER: _ClassVar[int]
    error: FrameError
    world: int
    def __init__(self, world: _Optional[int] = ..., error: _Optional[_Union[FrameError, _Mapping]] = ...) -> None: ...

class WorldErrors(_message.Message):
    __slots__ = ["errors"]
    ERRORS_FIELD_NUMBER: _ClassVar[int]
    errors: _containers.RepeatedCompositeFieldContainer[WorldError]
    def __init__(self, errors: _Optional[_Iterable[_Union[WorldError, _Mapping]]] = ...) -> None: ...

class AdvanceMode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
