"""A triangle that falls through another one, in the protocol's messages: frames with one contact."""

import struct

from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2, scene_pb2

FLOOR = -2, -2, 0, 2, -2, 0, 0, 2, 0
TRIANGLE = struct.pack("<3I", 0, 1, 2)


def tip_spec():
    spec = scene_pb2.SceneSpec(mode=scene_pb2.DETECTION_MODE_CCD, position_format=scene_pb2.POSITION_FORMAT_F32)
    for name in ("floor", "tip"):
        spec.meshes.add(name=name, vertex_count=3, triangles=TRIANGLE)
    return spec


def tip_request():
    return api.CreateSceneRequest(spec=tip_spec())


def points(*values):
    return struct.pack(f"<{len(values)}f", *values)


def tip_at(z):
    return points(0, 0, z, -0.1, 0, 9, 0.1, 0, 9)


def tip_frame(frame_id, depth):
    """One contact, if depth is above 1."""
    frame, floor = frame_pb2.Frame(frame_id=frame_id), points(*FLOOR)
    frame.updates.add(mesh=0, start_positions=floor, positions=floor)
    frame.updates.add(mesh=1, start_positions=tip_at(1), positions=tip_at(1 - depth))
    return frame
