from collided.v1 import added_in_pb2 as _added_in_pb2
from collided.v1 import contact_pb2 as _contact_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

ACCURACY_CANDIDATES: Accuracy
ACCURACY_CERTIFIED: Accuracy
ACCURACY_EXACT: Accuracy
ACCURACY_FAST: Accuracy
ACCURACY_GUARDED: Accuracy
ACCURACY_UNSPECIFIED: Accuracy
BACKEND_AUTO: Backend
BACKEND_CPU: Backend
BACKEND_CUDA: Backend
BACKEND_UNSPECIFIED: Backend
BROAD_PHASE_ENGINE_ALL_PAIRS: BroadPhaseEngine
BROAD_PHASE_ENGINE_BOTTOM_UP_OCTREE: BroadPhaseEngine
BROAD_PHASE_ENGINE_LBVH: BroadPhaseEngine
BROAD_PHASE_ENGINE_OCTREE: BroadPhaseEngine
BROAD_PHASE_ENGINE_TOP_DOWN_OCTREE: BroadPhaseEngine
BROAD_PHASE_ENGINE_TWO_LEVEL_GRID: BroadPhaseEngine
BROAD_PHASE_ENGINE_UNIFORM_GRID: BroadPhaseEngine
BROAD_PHASE_ENGINE_UNSPECIFIED: BroadPhaseEngine
BROAD_PHASE_ENGINE_VSS: BroadPhaseEngine
DESCRIPTOR: _descriptor.FileDescriptor
DETECTION_MODE_CCD: DetectionMode
DETECTION_MODE_DCD: DetectionMode
DETECTION_MODE_DCD_AND_CCD: DetectionMode
DETECTION_MODE_UNSPECIFIED: DetectionMode
MESH_MOTION_DEFORMABLE: MeshMotion
MESH_MOTION_RIGID: MeshMotion
MESH_MOTION_STATIC: MeshMotion
MESH_MOTION_UNSPECIFIED: MeshMotion
POSITION_FORMAT_F32: PositionFormat
POSITION_FORMAT_F64: PositionFormat
POSITION_FORMAT_Q16: PositionFormat
POSITION_FORMAT_UNSPECIFIED: PositionFormat
REPORT_ALL: Report
REPORT_ANY_HIT: Report
REPORT_EARLIEST_ONLY: Report
REPORT_UNSPECIFIED: Report
REUSE_OFF: Reuse
REUSE_ON: Reuse
REUSE_UNSPECIFIED: Reuse
SCENE_STATE_AWAITING_MESHES: SceneState
SCENE_STATE_READY: SceneState
SCENE_STATE_UNSPECIFIED: SceneState

class MemoryPart(_message.Message):
    __slots__ = ["bytes", "part"]
    BYTES_FIELD_NUMBER: _ClassVar[int]
    PART_FIELD_NUMBER: _ClassVar[int]
    bytes: int
    part: str
    def __init__(self, part: _Optional[str] = ..., bytes: _Optional[int] = ...) -> None: ...

class MeshEdit(_message.Message):
    __slots__ = ["mesh", "spec"]
    MESH_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    mesh: int
    spec: MeshSpec
    def __init__(self, mesh: _Optional[int] = ..., spec: _Optional[_Union[MeshSpec, _Mapping]] = ...) -> None: ...

class MeshPair(_message.Message):
    __slots__ = ["first", "second"]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    first: int
    second: int
    def __init__(self, first: _Optional[int] = ..., second: _Optional[int] = ...) -> None: ...

class MeshSpec(_message.Message):
    __slots__ = ["collide_mask", "edge_count", "edges", "exclude_rest_pairs", "exclude_rings", "groups", "half_thickness", "motion", "name", "no_self_contacts", "point_count", "points", "solid", "triangle_count", "triangles", "vertex_count"]
    COLLIDE_MASK_FIELD_NUMBER: _ClassVar[int]
    EDGES_FIELD_NUMBER: _ClassVar[int]
    EDGE_COUNT_FIELD_NUMBER: _ClassVar[int]
    EXCLUDE_REST_PAIRS_FIELD_NUMBER: _ClassVar[int]
    EXCLUDE_RINGS_FIELD_NUMBER: _ClassVar[int]
    GROUPS_FIELD_NUMBER: _ClassVar[int]
    HALF_THICKNESS_FIELD_NUMBER: _ClassVar[int]
    MOTION_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    NO_SELF_CONTACTS_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    POINT_COUNT_FIELD_NUMBER: _ClassVar[int]
    SOLID_FIELD_NUMBER: _ClassVar[int]
    TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    TRIANGLE_COUNT_FIELD_NUMBER: _ClassVar[int]
    VERTEX_COUNT_FIELD_NUMBER: _ClassVar[int]
    collide_mask: int
    edge_count: int
    edges: bytes
    exclude_rest_pairs: bool
    exclude_rings: int
    groups: int
    half_thickness: float
    motion: MeshMotion
    name: str
    no_self_contacts: bool
    point_count: int
    points: bytes
    solid: bool
    triangle_count: int
    triangles: bytes
    vertex_count: int
    def __init__(self, name: _Optional[str] = ..., vertex_count: _Optional[int] = ..., motion: _Optional[_Union[MeshMotion, str]] = ..., groups: _Optional[int] = ..., collide_mask: _Optional[int] = ..., no_self_contacts: bool = ..., triangle_count: _Optional[int] = ..., triangles: _Optional[bytes] = ..., exclude_rings: _Optional[int] = ..., exclude_rest_pairs: bool = ..., edges: _Optional[bytes] = ..., points: _Optional[bytes] = ..., edge_count: _Optional[int] = ..., point_count: _Optional[int] = ..., half_thickness: _Optional[float] = ..., solid: bool = ...) -> None: ...

class QuantizationBox(_message.Message):
    __slots__ = ["lower", "upper"]
    LOWER_FIELD_NUMBER: _ClassVar[int]
    UPPER_FIELD_NUMBER: _ClassVar[int]
    lower: _containers.RepeatedScalarFieldContainer[float]
    upper: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, lower: _Optional[_Iterable[float]] = ..., upper: _Optional[_Iterable[float]] = ...) -> None: ...

class Scene(_message.Message):
    __slots__ = ["device", "device_id", "edge_count", "edit_count", "endpoint", "last_frame_id", "lease_seconds", "memory", "resume_token", "scene_id", "spec", "state", "triangle_count", "vertex_count", "worlds"]
    DEVICE_FIELD_NUMBER: _ClassVar[int]
    DEVICE_ID_FIELD_NUMBER: _ClassVar[int]
    EDGE_COUNT_FIELD_NUMBER: _ClassVar[int]
    EDIT_COUNT_FIELD_NUMBER: _ClassVar[int]
    ENDPOINT_FIELD_NUMBER: _ClassVar[int]
    LAST_FRAME_ID_FIELD_NUMBER: _ClassVar[int]
    LEASE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    MEMORY_FIELD_NUMBER: _ClassVar[int]
    RESUME_TOKEN_FIELD_NUMBER: _ClassVar[int]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    TRIANGLE_COUNT_FIELD_NUMBER: _ClassVar[int]
    VERTEX_COUNT_FIELD_NUMBER: _ClassVar[int]
    WORLDS_FIELD_NUMBER: _ClassVar[int]
    device: str
    device_id: str
    edge_count: int
    edit_count: int
    endpoint: str
    last_frame_id: int
    lease_seconds: float
    memory: _containers.RepeatedCompositeFieldContainer[MemoryPart]
    resume_token: str
    scene_id: str
    spec: SceneSpec
    state: SceneState
    triangle_count: int
    vertex_count: int
    worlds: int
    def __init__(self, scene_id: _Optional[str] = ..., spec: _Optional[_Union[SceneSpec, _Mapping]] = ..., state: _Optional[_Union[SceneState, str]] = ..., device: _Optional[str] = ..., vertex_count: _Optional[int] = ..., edge_count: _Optional[int] = ..., triangle_count: _Optional[int] = ..., memory: _Optional[_Iterable[_Union[MemoryPart, _Mapping]]] = ..., last_frame_id: _Optional[int] = ..., lease_seconds: _Optional[float] = ..., endpoint: _Optional[str] = ..., resume_token: _Optional[str] = ..., edit_count: _Optional[int] = ..., worlds: _Optional[int] = ..., device_id: _Optional[str] = ...) -> None: ...

class SceneEdit(_message.Message):
    __slots__ = ["exclude_meshes", "include_meshes", "meshes"]
    EXCLUDE_MESHES_FIELD_NUMBER: _ClassVar[int]
    INCLUDE_MESHES_FIELD_NUMBER: _ClassVar[int]
    MESHES_FIELD_NUMBER: _ClassVar[int]
    exclude_meshes: _containers.RepeatedCompositeFieldContainer[MeshPair]
    include_meshes: _containers.RepeatedCompositeFieldContainer[MeshPair]
    meshes: _containers.RepeatedCompositeFieldContainer[MeshEdit]
    def __init__(self, meshes: _Optional[_Iterable[_Union[MeshEdit, _Mapping]]] = ..., exclude_meshes: _Optional[_Iterable[_Union[MeshPair, _Mapping]]] = ..., include_meshes: _Optional[_Iterable[_Union[MeshPair, _Mapping]]] = ...) -> None: ...

class SceneSpec(_message.Message):
    __slots__ = ["accuracy", "backend", "broad_phase_engine", "delta", "device", "display_name", "excluded_meshes", "expected_contacts", "fields", "kinds", "memory_budget_bytes", "meshes", "min_separation", "mode", "part_devices", "position_format", "quantization_box", "report", "rest_distance", "reuse", "thickness"]
    ACCURACY_FIELD_NUMBER: _ClassVar[int]
    BACKEND_FIELD_NUMBER: _ClassVar[int]
    BROAD_PHASE_ENGINE_FIELD_NUMBER: _ClassVar[int]
    DELTA_FIELD_NUMBER: _ClassVar[int]
    DEVICE_FIELD_NUMBER: _ClassVar[int]
    DISPLAY_NAME_FIELD_NUMBER: _ClassVar[int]
    EXCLUDED_MESHES_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_CONTACTS_FIELD_NUMBER: _ClassVar[int]
    FIELDS_FIELD_NUMBER: _ClassVar[int]
    KINDS_FIELD_NUMBER: _ClassVar[int]
    MEMORY_BUDGET_BYTES_FIELD_NUMBER: _ClassVar[int]
    MESHES_FIELD_NUMBER: _ClassVar[int]
    MIN_SEPARATION_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    PART_DEVICES_FIELD_NUMBER: _ClassVar[int]
    POSITION_FORMAT_FIELD_NUMBER: _ClassVar[int]
    QUANTIZATION_BOX_FIELD_NUMBER: _ClassVar[int]
    REPORT_FIELD_NUMBER: _ClassVar[int]
    REST_DISTANCE_FIELD_NUMBER: _ClassVar[int]
    REUSE_FIELD_NUMBER: _ClassVar[int]
    THICKNESS_FIELD_NUMBER: _ClassVar[int]
    accuracy: Accuracy
    backend: Backend
    broad_phase_engine: BroadPhaseEngine
    delta: float
    device: str
    display_name: str
    excluded_meshes: _containers.RepeatedCompositeFieldContainer[MeshPair]
    expected_contacts: int
    fields: _containers.RepeatedScalarFieldContainer[_contact_pb2.ContactField]
    kinds: _containers.RepeatedScalarFieldContainer[_contact_pb2.ContactKind]
    memory_budget_bytes: int
    meshes: _containers.RepeatedCompositeFieldContainer[MeshSpec]
    min_separation: float
    mode: DetectionMode
    part_devices: _containers.RepeatedScalarFieldContainer[str]
    position_format: PositionFormat
    quantization_box: QuantizationBox
    report: Report
    rest_distance: float
    reuse: Reuse
    thickness: float
    def __init__(self, display_name: _Optional[str] = ..., backend: _Optional[_Union[Backend, str]] = ..., mode: _Optional[_Union[DetectionMode, str]] = ..., accuracy: _Optional[_Union[Accuracy, str]] = ..., position_format: _Optional[_Union[PositionFormat, str]] = ..., thickness: _Optional[float] = ..., delta: _Optional[float] = ..., kinds: _Optional[_Iterable[_Union[_contact_pb2.ContactKind, str]]] = ..., fields: _Optional[_Iterable[_Union[_contact_pb2.ContactField, str]]] = ..., memory_budget_bytes: _Optional[int] = ..., meshes: _Optional[_Iterable[_Union[MeshSpec, _Mapping]]] = ..., report: _Optional[_Union[Report, str]] = ..., broad_phase_engine: _Optional[_Union[BroadPhaseEngine, str]] = ..., min_separation: _Optional[float] = ..., excluded_meshes: _Optional[_Iterable[_Union[MeshPair, _Mapping]]] = ..., rest_distance: _Optional[float] = ..., quantization_box: _Optional[_Union[QuantizationBox, _Mapping]] = ..., reuse: _Optional[_Union[Reuse, str]] = ..., device: _Optional[str] = ..., expected_contacts: _Optional[int] = ..., part_devices: _Optional[_Iterable[str]] = ...) -> None: ...

class Backend(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class DetectionMode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class Accuracy(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class Report(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class BroadPhaseEngine(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class Reuse(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class PositionFormat(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class MeshMotion(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class SceneState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
