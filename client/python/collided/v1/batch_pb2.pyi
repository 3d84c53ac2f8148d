from collided.v1 import contact_pb2 as _contact_pb2
from collided.v1 import frame_pb2 as _frame_pb2
from collided.v1 import scene_pb2 as _scene_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class CreateScenesRequest(_message.Message):
    __slots__ = ["count", "lease_seconds", "request_id", "spec"]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    LEASE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    count: int
    lease_seconds: float
    request_id: str
    spec: _scene_pb2.SceneSpec
    def __init__(self, request_id: _Optional[str] = ..., spec: _Optional[_Union[_scene_pb2.SceneSpec, _Mapping]] = ..., count: _Optional[int] = ..., lease_seconds: _Optional[float] = ...) -> None: ...

class CreateScenesResponse(_message.Message):
    __slots__ = ["scenes"]
    SCENES_FIELD_NUMBER: _ClassVar[int]
    scenes: _scene_pb2.Scene
    def __init__(self, scenes: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ...) -> None: ...

class DetectBatchRequest(_message.Message):
    __slots__ = ["frames", "max_answer_bytes"]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    MAX_ANSWER_BYTES_FIELD_NUMBER: _ClassVar[int]
    frames: _containers.RepeatedCompositeFieldContainer[SetFrame]
    max_answer_bytes: int
    def __init__(self, frames: _Optional[_Iterable[_Union[SetFrame, _Mapping]]] = ..., max_answer_bytes: _Optional[int] = ...) -> None: ...

class DetectBatchResponse(_message.Message):
    __slots__ = ["answers"]
    ANSWERS_FIELD_NUMBER: _ClassVar[int]
    answers: _containers.RepeatedCompositeFieldContainer[SetAnswer]
    def __init__(self, answers: _Optional[_Iterable[_Union[SetAnswer, _Mapping]]] = ...) -> None: ...

class SetAnswer(_message.Message):
    __slots__ = ["contacts", "done", "error", "errors", "frame_id", "scene_id"]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    DONE_FIELD_NUMBER: _ClassVar[int]
    ERRORS_FIELD_NUMBER: _ClassVar[int]
    ERROR_FIELD_NUMBER: _ClassVar[int]
    FRAME_ID_FIELD_NUMBER: _ClassVar[int]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    contacts: _containers.RepeatedCompositeFieldContainer[WorldContacts]
    done: _frame_pb2.FrameDone
    error: _frame_pb2.FrameError
    errors: _containers.RepeatedCompositeFieldContainer[_frame_pb2.WorldError]
    frame_id: int
    scene_id: str
    def __init__(self, scene_id: _Optional[str] = ..., frame_id: _Optional[int] = ..., error: _Optional[_Union[_frame_pb2.FrameError, _Mapping]] = ..., errors: _Optional[_Iterable[_Union[_frame_pb2.WorldError, _Mapping]]] = ..., contacts: _Optional[_Iterable[_Union[WorldContacts, _Mapping]]] = ..., done: _Optional[_Union[_frame_pb2.FrameDone, _Mapping]] = ...) -> None: ...

class SetFrame(_message.Message):
    __slots__ = ["accuracy", "delta", "frame_id", "meshes", "mode", "positions", "scene_id", "start_positions", "worlds"]
    ACCURACY_FIELD_NUMBER: _ClassVar[int]
    DELTA_FIELD_NUMBER: _ClassVar[int]
    FRAME_ID_FIELD_NUMBER: _ClassVar[int]
    MESHES_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    SCENE_ID_FIELD_NUMBER: _ClassVar[int]
    START_POSITIONS_FIELD_NUMBER: _ClassVar[int]
    WORLDS_FIELD_NUMBER: _ClassVar[int]
    accuracy: _scene_pb2.Accuracy
    delta: float
    frame_id: int
    meshes: _containers.RepeatedScalarFieldContainer[int]
    mode: _scene_pb2.DetectionMode
    positions: bytes
    scene_id: str
    start_positions: bytes
    worlds: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, scene_id: _Optional[str] = ..., frame_id: _Optional[int] = ..., worlds: _Optional[_Iterable[int]] = ..., meshes: _Optional[_Iterable[int]] = ..., positions: _Optional[bytes] = ..., start_positions: _Optional[bytes] = ..., accuracy: _Optional[_Union[_scene_pb2.Accuracy, str]] = ..., delta: _Optional[float] = ..., mode: _Optional[_Union[_scene_pb2.DetectionMode, str]] = ...) -> None: ...

class WorldContacts(_message.Message):
    __slots__ = ["begin", "contacts"]
    BEGIN_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    begin: bytes
    contacts: _contact_pb2.ContactChunk
    def __init__(self, begin: _Optional[bytes] = ..., contacts: _Optional[_Union[_contact_pb2.ContactChunk, _Mapping]] = ...) -> None: ...
