from collided.v1 import added_in_pb2 as _added_in_pb2
from collided.v1 import shared_range_pb2 as _shared_range_pb2
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Mapping as _Mapping, Optional as _Optional, Union as _Union

CONTACT_FIELD_DISTANCE: ContactField
CONTACT_FIELD_ELEMENTS: ContactField
CONTACT_FIELD_FEATURES: ContactField
CONTACT_FIELD_FLAGS: ContactField
CONTACT_FIELD_NORMAL: ContactField
CONTACT_FIELD_PAIR_STATES: ContactField
CONTACT_FIELD_SIGNED_DISTANCE: ContactField
CONTACT_FIELD_STENCIL: ContactField
CONTACT_FIELD_TOI: ContactField
CONTACT_FIELD_UNSPECIFIED: ContactField
CONTACT_FIELD_WEIGHTS: ContactField
CONTACT_FLAG_CAPPED: ContactFlag
CONTACT_FLAG_CERTIFIED: ContactFlag
CONTACT_FLAG_COVERED: ContactFlag
CONTACT_FLAG_INITIAL: ContactFlag
CONTACT_FLAG_NEAR: ContactFlag
CONTACT_FLAG_SEPARATING: ContactFlag
CONTACT_FLAG_TOUCHING: ContactFlag
CONTACT_FLAG_UNSPECIFIED: ContactFlag
CONTACT_KIND_EDGE_EDGE: ContactKind
CONTACT_KIND_EDGE_TRIANGLE: ContactKind
CONTACT_KIND_TRIANGLE_TRIANGLE: ContactKind
CONTACT_KIND_UNSPECIFIED: ContactKind
CONTACT_KIND_VERTEX_SOLID: ContactKind
CONTACT_KIND_VERTEX_TRIANGLE: ContactKind
DESCRIPTOR: _descriptor.FileDescriptor
MESH_PAIR_STATE_FIRST_INSIDE: MeshPairState
MESH_PAIR_STATE_OVERLAPPING: MeshPairState
MESH_PAIR_STATE_SECOND_INSIDE: MeshPairState
MESH_PAIR_STATE_TOUCHING: MeshPairState
MESH_PAIR_STATE_UNSPECIFIED: MeshPairState

class ContactChunk(_message.Message):
    __slots__ = ["count", "distance", "elements", "features", "flags", "kind", "normals", "shared", "signed_distances", "stencils", "toi", "weights", "worlds"]
    COUNT_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    ELEMENTS_FIELD_NUMBER: _ClassVar[int]
    FEATURES_FIELD_NUMBER: _ClassVar[int]
    FLAGS_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    NORMALS_FIELD_NUMBER: _ClassVar[int]
    SHARED_FIELD_NUMBER: _ClassVar[int]
    SIGNED_DISTANCES_FIELD_NUMBER: _ClassVar[int]
    STENCILS_FIELD_NUMBER: _ClassVar[int]
    TOI_FIELD_NUMBER: _ClassVar[int]
    WEIGHTS_FIELD_NUMBER: _ClassVar[int]
    WORLDS_FIELD_NUMBER: _ClassVar[int]
    count: int
    distance: bytes
    elements: bytes
    features: bytes
    flags: bytes
    kind: ContactKind
    normals: bytes
    shared: SharedArrays
    signed_distances: bytes
    stencils: bytes
    toi: bytes
    weights: bytes
    worlds: bytes
    def __init__(self, kind: _Optional[_Union[ContactKind, str]] = ..., count: _Optional[int] = ..., elements: _Optional[bytes] = ..., stencils: _Optional[bytes] = ..., toi: _Optional[bytes] = ..., distance: _Optional[bytes] = ..., weights: _Optional[bytes] = ..., normals: _Optional[bytes] = ..., flags: _Optional[bytes] = ..., shared: _Optional[_Union[SharedArrays, _Mapping]] = ..., worlds: _Optional[bytes] = ..., features: _Optional[bytes] = ..., signed_distances: _Optional[bytes] = ...) -> None: ...

class MeshPairs(_message.Message):
    __slots__ = ["deepest", "depths", "inside", "meshes", "states"]
    DEEPEST_FIELD_NUMBER: _ClassVar[int]
    DEPTHS_FIELD_NUMBER: _ClassVar[int]
    INSIDE_FIELD_NUMBER: _ClassVar[int]
    MESHES_FIELD_NUMBER: _ClassVar[int]
    STATES_FIELD_NUMBER: _ClassVar[int]
    deepest: bytes
    depths: bytes
    inside: bytes
    meshes: bytes
    states: bytes
    def __init__(self, meshes: _Optional[bytes] = ..., states: _Optional[bytes] = ..., inside: _Optional[bytes] = ..., deepest: _Optional[bytes] = ..., depths: _Optional[bytes] = ...) -> None: ...

class SharedArrays(_message.Message):
    __slots__ = ["distance", "elements", "features", "flags", "normals", "signed_distances", "stencils", "toi", "weights", "worlds"]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    ELEMENTS_FIELD_NUMBER: _ClassVar[int]
    FEATURES_FIELD_NUMBER: _ClassVar[int]
    FLAGS_FIELD_NUMBER: _ClassVar[int]
    NORMALS_FIELD_NUMBER: _ClassVar[int]
    SIGNED_DISTANCES_FIELD_NUMBER: _ClassVar[int]
    STENCILS_FIELD_NUMBER: _ClassVar[int]
    TOI_FIELD_NUMBER: _ClassVar[int]
    WEIGHTS_FIELD_NUMBER: _ClassVar[int]
    WORLDS_FIELD_NUMBER: _ClassVar[int]
    distance: _shared_range_pb2.SharedRange
    elements: _shared_range_pb2.SharedRange
    features: _shared_range_pb2.SharedRange
    flags: _shared_range_pb2.SharedRange
    normals: _shared_range_pb2.SharedRange
    signed_distances: _shared_range_pb2.SharedRange
    stencils: _shared_range_pb2.SharedRange
    toi: _shared_range_pb2.SharedRange
    weights: _shared_range_pb2.SharedRange
    worlds: _shared_range_pb2.SharedRange
    def __init__(self, elements: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., stencils: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., toi: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., distance: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., weights: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., normals: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., flags: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., worlds: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., features: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ..., signed_distances: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ...) -> None: ...

class ContactKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class ContactField(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class ContactFlag(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class MeshPairState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
