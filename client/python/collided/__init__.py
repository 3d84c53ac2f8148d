"""Contacts of moving meshes: numpy in and out, by the daemon `collided`.

    contacts = collided.detect(V0, V1, F)

`detect` and `proximity` ask one question; a `Session` streams frames of a scene, whose meshes go up once. Without a server
they use $COLLIDED_SERVER, or a daemon that this process starts for itself. `collided.aio` has the same for asyncio,
`collided.gpu` sessions whose positions and contacts stay on the daemon's GPU.
"""

import importlib
from typing import Any

from collided.batch import SceneBatch, WorldContacts
from collided.connection.client import Client
from collided.connection.mesh_elements import MeshElements
from collided.connection.options import ConnectOptions
from collided.connection.own_daemon import OwnDaemon
from collided.contacts import Contacts, Feature, Flag, MeshPair, MeshPairs, OnEdge, OnTriangle, PairState
from collided.detection import detect, proximity
from collided.errors import (Aborted, AlreadyExists, Cancelled, DataLoss, DeadlineExceeded, Error, FailedPrecondition,
                             Internal, InvalidArgument, NotFound, PermissionDenied, ResourceExhausted, Unauthenticated,
                             Unavailable, Unimplemented)
from collided.frames.advance import Shortened
from collided.frames.edit import Edit
from collided.frames.options import FrameOptions
from collided.frames.updates import Rigid, Sparse
from collided.meshes import Mesh
from collided.options import SceneOptions
from collided.positions import Box, move_along, move_rigidly, pack_quantized, pose_along, unpack_quantized
from collided.scene import Scene
from collided.session import Session
from collided.watch import Watched, Watcher

__version__ = "0.1.0"
__all__ = ["Aborted", "AlreadyExists", "Box", "Cancelled", "Client", "ConnectOptions", "Contacts", "DataLoss",
           "DeadlineExceeded", "Edit", "Error", "FailedPrecondition", "Feature", "Flag", "FrameOptions", "Internal",
           "InvalidArgument", "Mesh", "MeshElements", "MeshPair", "MeshPairs", "NotFound", "OnEdge", "OnTriangle", "OwnDaemon",
           "PairState", "PermissionDenied", "ResourceExhausted", "Rigid", "Scene", "SceneBatch", "SceneOptions", "Session",
           "Shortened", "Sparse", "Unauthenticated", "Unavailable", "Unimplemented", "Watched", "Watcher",
           "WorldContacts", "detect", "move_along", "move_rigidly", "pack_quantized", "pose_along", "proximity",
           "unpack_quantized"]


def __getattr__(name: str) -> Any:
    """`collided.aio` and `collided.gpu`, imported when they are first used."""
    if name in ("aio", "gpu"):
        return importlib.import_module(f"collided.{name}")
    raise AttributeError(f"module 'collided' has no attribute {name!r}")
