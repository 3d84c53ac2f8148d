from collided.v1 import batch_pb2 as _batch_pb2
from collided.v1 import contact_pb2 as _contact_pb2
from collided.v1 import frame_pb2 as _frame_pb2
from collided.v1 import scene_pb2 as _scene_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DELIVERY_POLICY_LATEST_WINS: DeliveryPolicy
DELIVERY_POLICY_LOSSLESS: DeliveryPolicy
DELIVERY_POLICY_UNSPECIFIED: DeliveryPolicy
DESCRIPTOR: _descriptor.FileDescriptor

class ContactBytes(_message.Message):
    __slots__ = ["edge_edge", "edge_triangle", "triangle_triangle", "vertex_solid", "vertex_triangle"]
    EDGE_EDGE_FIELD_NUMBER: _ClassVar[int]
    EDGE_TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    TRIANGLE_TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    VERTEX_SOLID_FIELD_NUMBER: _ClassVar[int]
    VERTEX_TRIANGLE_FIELD_NUMBER: _ClassVar[int]
    edge_edge: int
    edge_triangle: int
    triangle_triangle: int
    vertex_solid: int
    vertex_triangle: int
    def __init__(self, vertex_triangle: _Optional[int] = ..., edge_edge: _Optional[int] = ..., triangle_triangle: _Optional[int] = ..., edge_triangle: _Optional[int] = ..., vertex_solid: _Optional[int] = ...) -> None: ...

class CreateSceneRequest(_message.Message):
    __slots__ = ["lease_seconds", "request_id", "spec"]
    LEASE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    lease_seconds: float
    request_id: str
    spec: _scene_pb2.SceneSpec
    def __init__(self, request_id: _Optional[str] = ..., spec: _Optional[_Union[_scene_pb2.SceneSpec, _Mapping]] = ..., lease_seconds: _Optional[float] = ...) -> None: ...

class CreateSceneResponse(_message.Message):
    __slots__ = ["scene"]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    scene: _scene_pb2.Scene
    def __init__(self, scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ...) -> None: ...

class DeleteSceneRequest(_message.Message):
    __slots__ = ["scene_id"]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    scene_id: str
    def __init__(self, scene_id: _Optional[str] = ...) -> None: ...

class DeleteSceneResponse(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class DetectFrameRequest(_message.Message):
    __slots__ = ["frame", "scene_id"]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    frame: _frame_pb2.Frame
    scene_id: str
    def __init__(self, scene_id: _Optional[str] = ..., frame: _Optional[_Union[_frame_pb2.Frame, _Mapping]] = ...) -> None: ...

class DetectFrameResponse(_message.Message):
    __slots__ = ["contacts", "done"]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    DONE_FIELD_NUMBER: _ClassVar[int]
    contacts: _containers.RepeatedCompositeFieldContainer[_contact_pb2.ContactChunk]
    done: _frame_pb2.FrameDone
    def __init__(self, contacts: _Optional[_Iterable[_Union[_contact_pb2.ContactChunk, _Mapping]]] = ..., done: _Optional[_Union[_frame_pb2.FrameDone, _Mapping]] = ...) -> None: ...

class Device(_message.Message):
    __slots__ = ["backend", "free_bytes", "id", "load", "max_bytes", "memory_bytes", "name", "scenes", "uuid"]
    BACKEND_FIELD_NUMBER: _ClassVar[int]
    FREE_BYTES_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    LOAD_FIELD_NUMBER: _ClassVar[int]
    MAX_BYTES_FIELD_NUMBER: _ClassVar[int]
    MEMORY_BYTES_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    SCENES_FIELD_NUMBER: _ClassVar[int]
    UUID_FIELD_NUMBER: _ClassVar[int]
    backend: _scene_pb2.Backend
    free_bytes: int
    id: str
    load: float
    max_bytes: int
    memory_bytes: int
    name: str
    scenes: int
    uuid: str
    def __init__(self, backend: _Optional[_Union[_scene_pb2.Backend, str]] = ..., name: _Optional[str] = ..., memory_bytes: _Optional[int] = ..., id: _Optional[str] = ..., uuid: _Optional[str] = ..., max_bytes: _Optional[int] = ..., free_bytes: _Optional[int] = ..., scenes: _Optional[int] = ..., load: _Optional[float] = ...) -> None: ...

class Draining(_message.Message):
    __slots__ = ["deadline_seconds"]
    DEADLINE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    deadline_seconds: float
    def __init__(self, deadline_seconds: _Optional[float] = ...) -> None: ...

class EstimateSceneRequest(_message.Message):
    __slots__ = ["spec"]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    spec: _scene_pb2.SceneSpec
    def __init__(self, spec: _Optional[_Union[_scene_pb2.SceneSpec, _Mapping]] = ...) -> None: ...

class EstimateSceneResponse(_message.Message):
    __slots__ = ["contact_bytes", "device", "device_id", "first_frame_bytes", "frame_bytes", "memory", "spec", "stages", "triangle_count", "vertex_count"]
    CONTACT_BYTES_FIELD_NUMBER: _ClassVar[int]
    DEVICE_FIELD_NUMBER: _ClassVar[int]
    DEVICE_ID_FIELD_NUMBER: _ClassVar[int]
    FIRST_FRAME_BYTES_FIELD_NUMBER: _ClassVar[int]
    FRAME_BYTES_FIELD_NUMBER: _ClassVar[int]
    MEMORY_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    STAGES_FIELD_NUMBER: _ClassVar[int]
    TRIANGLE_COUNT_FIELD_NUMBER: _ClassVar[int]
    VERTEX_COUNT_FIELD_NUMBER: _ClassVar[int]
    contact_bytes: ContactBytes
    device: str
    device_id: str
    first_frame_bytes: int
    frame_bytes: int
    memory: _containers.RepeatedCompositeFieldContainer[_scene_pb2.MemoryPart]
    spec: _scene_pb2.SceneSpec
    stages: _containers.RepeatedScalarFieldContainer[str]
    triangle_count: int
    vertex_count: int
    def __init__(self, spec: _Optional[_Union[_scene_pb2.SceneSpec, _Mapping]] = ..., device: _Optional[str] = ..., vertex_count: _Optional[int] = ..., triangle_count: _Optional[int] = ..., memory: _Optional[_Iterable[_Union[_scene_pb2.MemoryPart, _Mapping]]] = ..., first_frame_bytes: _Optional[int] = ..., frame_bytes: _Optional[int] = ..., contact_bytes: _Optional[_Union[ContactBytes, _Mapping]] = ..., stages: _Optional[_Iterable[str]] = ..., device_id: _Optional[str] = ...) -> None: ...

class FrameSkipped(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class GetMeshRequest(_message.Message):
    __slots__ = ["first_element", "mesh", "scene_id"]
    FIRST_ELEMENT_FIELD_NUMBER: _ClassVar[int]
    MESH_FIELD_NUMBER: _ClassVar[int]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    first_element: int
    mesh: int
    scene_id: str
    def __init__(self, scene_id: _Optional[str] = ..., mesh: _Optional[int] = ..., first_element: _Optional[int] = ...) -> None: ...

class GetMeshResponse(_message.Message):
    __slots__ = ["edit_count", "element_count", "elements", "vertex_count"]
    EDIT_COUNT_FIELD_NUMBER: _ClassVar[int]
    ELEMENTS_FIELD_NUMBER: _ClassVar[int]
    ELEMENT_COUNT_FIELD_NUMBER: _ClassVar[int]
    VERTEX_COUNT_FIELD_NUMBER: _ClassVar[int]
    edit_count: int
    element_count: int
    elements: bytes
    vertex_count: int
    def __init__(self, elements: _Optional[bytes] = ..., element_count: _Optional[int] = ..., vertex_count: _Optional[int] = ..., edit_count: _Optional[int] = ...) -> None: ...

class GetSceneRequest(_message.Message):
    __slots__ = ["scene_id"]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    scene_id: str
    def __init__(self, scene_id: _Optional[str] = ...) -> None: ...

class GetSceneResponse(_message.Message):
    __slots__ = ["scene"]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    scene: _scene_pb2.Scene
    def __init__(self, scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ...) -> None: ...

class GetServerInfoRequest(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class GetServerInfoResponse(_message.Message):
    __slots__ = ["devices", "features", "limits", "local_socket", "unusable_devices", "version"]
    DEVICES_FIELD_NUMBER: _ClassVar[int]
    FEATURES_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    LOCAL_SOCKET_FIELD_NUMBER: _ClassVar[int]
    UNUSABLE_DEVICES_FIELD_NUMBER: _ClassVar[int]
    VERSION_FIELD_NUMBER: _ClassVar[int]
    devices: _containers.RepeatedCompositeFieldContainer[Device]
    features: _containers.RepeatedScalarFieldContainer[str]
    limits: ServerLimits
    local_socket: str
    unusable_devices: _containers.RepeatedCompositeFieldContainer[UnusableDevice]
    version: str
    def __init__(self, version: _Optional[str] = ..., devices: _Optional[_Iterable[_Union[Device, _Mapping]]] = ..., limits: _Optional[_Union[ServerLimits, _Mapping]] = ..., local_socket: _Optional[str] = ..., unusable_devices: _Optional[_Iterable[_Union[UnusableDevice, _Mapping]]] = ..., features: _Optional[_Iterable[str]] = ...) -> None: ...

class ListScenesRequest(_message.Message):
    __slots__ = ["page_size", "page_token"]
    PAGE_SIZE_FIELD_NUMBER: _ClassVar[int]
    PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    page_size: int
    page_token: str
    def __init__(self, page_size: _Optional[int] = ..., page_token: _Optional[str] = ...) -> None: ...

class ListScenesResponse(_message.Message):
    __slots__ = ["next_page_token", "scenes"]
    NEXT_PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    SCENES_FIELD_NUMBER: _ClassVar[int]
    next_page_token: str
    scenes: _containers.RepeatedCompositeFieldContainer[_scene_pb2.Scene]
    def __init__(self, scenes: _Optional[_Iterable[_Union[_scene_pb2.Scene, _Mapping]]] = ..., next_page_token: _Optional[str] = ...) -> None: ...

class OpenStream(_message.Message):
    __slots__ = ["delivery", "resume_token", "scene_id", "window"]
    DELIVERY_FIELD_NUMBER: _ClassVar[int]
    RESUME_TOKEN_FIELD_NUMBER: _ClassVar[int]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    WINDOW_FIELD_NUMBER: _ClassVar[int]
    delivery: DeliveryPolicy
    resume_token: str
    scene_id: str
    window: int
    def __init__(self, scene_id: _Optional[str] = ..., window: _Optional[int] = ..., delivery: _Optional[_Union[DeliveryPolicy, str]] = ..., resume_token: _Optional[str] = ...) -> None: ...

class ServerLimits(_message.Message):
    __slots__ = ["max_accuracy", "max_device_bytes", "max_device_bytes_per_client", "max_frame_seconds", "max_frames_per_second", "max_idle_seconds", "max_lease_seconds", "max_message_bytes", "max_scene_bytes", "max_scenes", "max_scenes_per_client", "max_streams", "max_streams_per_client", "max_triangles", "max_vertices", "max_window", "min_ping_seconds"]
    MAX_ACCURACY_FIELD_NUMBER: _ClassVar[int]
    MAX_DEVICE_BYTES_FIELD_NUMBER: _ClassVar[int]
    MAX_DEVICE_BYTES_PER_CLIENT_FIELD_NUMBER: _ClassVar[int]
    MAX_FRAMES_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_FRAME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    MAX_IDLE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    MAX_LEASE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    MAX_MESSAGE_BYTES_FIELD_NUMBER: _ClassVar[int]
    MAX_SCENES_FIELD_NUMBER: _ClassVar[int]
    MAX_SCENES_PER_CLIENT_FIELD_NUMBER: _ClassVar[int]
    MAX_SCENE_BYTES_FIELD_NUMBER: _ClassVar[int]
    MAX_STREAMS_FIELD_NUMBER: _ClassVar[int]
    MAX_STREAMS_PER_CLIENT_FIELD_NUMBER: _ClassVar[int]
    MAX_TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    MAX_VERTICES_FIELD_NUMBER: _ClassVar[int]
    MAX_WINDOW_FIELD_NUMBER: _ClassVar[int]
    MIN_PING_SECONDS_FIELD_NUMBER: _ClassVar[int]
    max_accuracy: _scene_pb2.Accuracy
    max_device_bytes: int
    max_device_bytes_per_client: int
    max_frame_seconds: float
    max_frames_per_second: float
    max_idle_seconds: float
    max_lease_seconds: float
    max_message_bytes: int
    max_scene_bytes: int
    max_scenes: int
    max_scenes_per_client: int
    max_streams: int
    max_streams_per_client: int
    max_triangles: int
    max_vertices: int
    max_window: int
    min_ping_seconds: float
    def __init__(self, max_message_bytes: _Optional[int] = ..., max_vertices: _Optional[int] = ..., max_triangles: _Optional[int] = ..., max_scenes: _Optional[int] = ..., max_scene_bytes: _Optional[int] = ..., max_window: _Optional[int] = ..., max_scenes_per_client: _Optional[int] = ..., max_device_bytes_per_client: _Optional[int] = ..., max_device_bytes: _Optional[int] = ..., max_streams: _Optional[int] = ..., max_streams_per_client: _Optional[int] = ..., max_frames_per_second: _Optional[float] = ..., max_idle_seconds: _Optional[float] = ..., max_lease_seconds: _Optional[float] = ..., max_frame_seconds: _Optional[float] = ..., max_accuracy: _Optional[_Union[_scene_pb2.Accuracy, str]] = ..., min_ping_seconds: _Optional[float] = ...) -> None: ...

class StreamFramesRequest(_message.Message):
    __slots__ = ["frame", "open"]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    OPEN_FIELD_NUMBER: _ClassVar[int]
    frame: _frame_pb2.Frame
    open: OpenStream
    def __init__(self, open: _Optional[_Union[OpenStream, _Mapping]] = ..., frame: _Optional[_Union[_frame_pb2.Frame, _Mapping]] = ...) -> None: ...

class StreamFramesResponse(_message.Message):
    __slots__ = ["contacts", "done", "draining", "error", "frame_id", "limits", "opened", "pairs", "shortened", "skipped", "world_errors"]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    DONE_FIELD_NUMBER: _ClassVar[int]
    DRAINING_FIELD_NUMBER: _ClassVar[int]
    ERROR_FIELD_NUMBER: _ClassVar[int]
    FRAME_ID_FIELD_NUMBER: _ClassVar[int]
    LIMITS_FIELD_NUMBER: _ClassVar[int]
    OPENED_FIELD_NUMBER: _ClassVar[int]
    PAIRS_FIELD_NUMBER: _ClassVar[int]
    SHORTENED_FIELD_NUMBER: _ClassVar[int]
    SKIPPED_FIELD_NUMBER: _ClassVar[int]
    WORLD_ERRORS_FIELD_NUMBER: _ClassVar[int]
    contacts: _contact_pb2.ContactChunk
    done: _frame_pb2.FrameDone
    draining: Draining
    error: _frame_pb2.FrameError
    frame_id: int
    limits: _contact_pb2.ContactChunk
    opened: StreamOpened
    pairs: _contact_pb2.MeshPairs
    shortened: _frame_pb2.ShortenedWays
    skipped: FrameSkipped
    world_errors: _frame_pb2.WorldErrors
    def __init__(self, frame_id: _Optional[int] = ..., opened: _Optional[_Union[StreamOpened, _Mapping]] = ..., contacts: _Optional[_Union[_contact_pb2.ContactChunk, _Mapping]] = ..., done: _Optional[_Union[_frame_pb2.FrameDone, _Mapping]] = ..., error: _Optional[_Union[_frame_pb2.FrameError, _Mapping]] = ..., skipped: _Optional[_Union[FrameSkipped, _Mapping]] = ..., draining: _Optional[_Union[Draining, _Mapping]] = ..., world_errors: _Optional[_Union[_frame_pb2.WorldErrors, _Mapping]] = ..., shortened: _Optional[_Union[_frame_pb2.ShortenedWays, _Mapping]] = ..., limits: _Optional[_Union[_contact_pb2.ContactChunk, _Mapping]] = ..., pairs: _Optional[_Union[_contact_pb2.MeshPairs, _Mapping]] = ...) -> None: ...

class StreamOpened(_message.Message):
    __slots__ = ["scene", "window"]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    WINDOW_FIELD_NUMBER: _ClassVar[int]
    scene: _scene_pb2.Scene
    window: int
    def __init__(self, scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., window: _Optional[int] = ...) -> None: ...

class UnusableDevice(_message.Message):
    __slots__ = ["backend", "id", "name", "reason"]
    BACKEND_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    backend: _scene_pb2.Backend
    id: str
    name: str
    reason: str
    def __init__(self, backend: _Optional[_Union[_scene_pb2.Backend, str]] = ..., id: _Optional[str] = ..., name: _Optional[str] = ..., reason: _Optional[str] = ...) -> None: ...

class UploadMeshRequest(_message.Message):
    __slots__ = ["mesh", "scene_id", "triangles"]
    MESH_FIELD_NUMBER: _ClassVar[int]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    mesh: int
    scene_id: str
    triangles: bytes
    def __init__(self, scene_id: _Optional[str] = ..., mesh: _Optional[int] = ..., triangles: _Optional[bytes] = ...) -> None: ...

class UploadMeshResponse(_message.Message):
    __slots__ = ["scene"]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    scene: _scene_pb2.Scene
    def __init__(self, scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ...) -> None: ...

class VertexSample(_message.Message):
    __slots__ = ["mesh", "positions", "vertex_stride"]
    MESH_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VERTEX_STRIDE_FIELD_NUMBER: _ClassVar[int]
    mesh: int
    positions: bytes
    vertex_stride: int
    def __init__(self, mesh: _Optional[int] = ..., vertex_stride: _Optional[int] = ..., positions: _Optional[bytes] = ...) -> None: ...

class WatchOpened(_message.Message):
    __slots__ = ["scene", "vertex_stride"]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    VERTEX_STRIDE_FIELD_NUMBER: _ClassVar[int]
    scene: _scene_pb2.Scene
    vertex_stride: int
    def __init__(self, scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., vertex_stride: _Optional[int] = ...) -> None: ...

class WatchSceneRequest(_message.Message):
    __slots__ = ["frame_interval", "max_contacts_per_kind", "max_frames_per_second", "position_meshes", "scene_id", "vertex_stride"]
    FRAME_INTERVAL_FIELD_NUMBER: _ClassVar[int]
    MAX_CONTACTS_PER_KIND_FIELD_NUMBER: _ClassVar[int]
    MAX_FRAMES_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    POSITION_MESHES_FIELD_NUMBER: _ClassVar[int]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    VERTEX_STRIDE_FIELD_NUMBER: _ClassVar[int]
    frame_interval: int
    max_contacts_per_kind: int
    max_frames_per_second: float
    position_meshes: _containers.RepeatedScalarFieldContainer[int]
    scene_id: str
    vertex_stride: int
    def __init__(self, scene_id: _Optional[str] = ..., frame_interval: _Optional[int] = ..., max_frames_per_second: _Optional[float] = ..., max_contacts_per_kind: _Optional[int] = ..., position_meshes: _Optional[_Iterable[int]] = ..., vertex_stride: _Optional[int] = ...) -> None: ...

class WatchSceneResponse(_message.Message):
    __slots__ = ["done", "edit_count", "frame_id", "omitted_contacts", "opened", "positions", "skipped_frames"]
    DONE_FIELD_NUMBER: _ClassVar[int]
    EDIT_COUNT_FIELD_NUMBER: _ClassVar[int]
    FRAME_ID_FIELD_NUMBER: _ClassVar[int]
    OMITTED_CONTACTS_FIELD_NUMBER: _ClassVar[int]
    OPENED_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    SKIPPED_FRAMES_FIELD_NUMBER: _ClassVar[int]
    done: _frame_pb2.FrameDone
    edit_count: int
    frame_id: int
    omitted_contacts: int
    opened: WatchOpened
    positions: _containers.RepeatedCompositeFieldContainer[VertexSample]
    skipped_frames: int
    def __init__(self, frame_id: _Optional[int] = ..., done: _Optional[_Union[_frame_pb2.FrameDone, _Mapping]] = ..., opened: _Optional[_Union[WatchOpened, _Mapping]] = ..., skipped_frames: _Optional[int] = ..., omitted_contacts: _Optional[int] = ..., positions: _Optional[_Iterable[_Union[VertexSample, _Mapping]]] = ..., edit_count: _Optional[int] = ...) -> None: ...

class DeliveryPolicy(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
