"""The engine in this process in the place of a connection to a daemon."""

from __future__ import annotations

import itertools
import math
from typing import Any

from collided.connection.client import Client, full_spec
from collided.connection.connection import Connection
from collided.connection.options import ConnectOptions
from collided.errors import Error, InvalidArgument, NotFound, Unimplemented
from collided.in_process.engine import EngineScene
from collided.in_process.library import find_library, load
from collided.layout import Layout
from collided.options import SceneOptions, check_seconds
from collided.v1 import collision_service_pb2 as api
from collided.v1 import scene_pb2

LOCAL = "local"  # the server's name
_ids = itertools.count(1)


class LocalClient(Client):
    """Scenes of the engine in this process. What only a daemon has raises Unimplemented: watching, sets of scenes, estimates,
    lists of scenes, edits, scenes on several devices. Leases do not end.

    Raises FailedPrecondition if libcollided.so is not found.
    """

    def __init__(self, **options: Any) -> None:
        self.options = ConnectOptions(**options)
        for name in ("token", "tls_ca", "tls_certificate", "tls_key", "tls_server_name"):
            if getattr(self.options, name):
                raise InvalidArgument(f"{name} is given, but server is 'local', and nothing is connected", field=name)
        self._library = load(find_library())
        self._scenes: dict[str, tuple[EngineScene, scene_pb2.Scene]] = {}

    @property
    def address(self) -> str:
        return LOCAL

    @property
    def place(self) -> str:
        return f"the engine in this process, {self._library.version}"

    @property
    def info(self) -> api.GetServerInfoResponse:
        raise _unimplemented("info")

    def check_known(self, request: Any, path: str = "", method: str = "") -> None:
        """The engine comes with the package, and what it lacks is refused by name."""

    def call(self, method: str, request: Any, scene_id: str = "", timeout: float | None = None,
             channel: Any = None) -> Any:
        raise _unimplemented(method)

    def separate_channel(self, endpoint: str = "", max_answer_bytes: int = 0) -> Any:
        raise _unimplemented("a connection of its own")

    def create_scene(self, layout: Layout, options: SceneOptions, lease_seconds: float,
                     tries: int = 1) -> scene_pb2.Scene:
        check_seconds(lease_seconds, "lease_seconds")
        spec = self._known_spec(layout, options)
        engine = EngineScene(self._library, spec, layout)
        message = scene_pb2.Scene(scene_id=f"local-{next(_ids)}", spec=spec, state=scene_pb2.SCENE_STATE_READY,
                                  triangle_count=sum(len(mesh.triangles) for _, mesh in layout.present()),
                                  lease_seconds=math.inf)
        self._scenes[message.scene_id] = engine, message
        return self.get_scene(message.scene_id)

    def _known_spec(self, layout: Layout, options: SceneOptions) -> scene_pb2.SceneSpec:
        """The engine knows all fields of contacts."""
        return full_spec(layout, options)

    def create_scenes(self, layout: Layout, options: SceneOptions, count: int, lease_seconds: float) -> scene_pb2.Scene:
        raise _unimplemented("a set of scenes")

    def engine(self, scene_id: str) -> EngineScene:
        """NotFound."""
        return self._find(scene_id)[0]

    def get_scene(self, scene_id: str) -> scene_pb2.Scene:
        engine, message = self._find(scene_id)
        engine.facts(message)
        return message

    def _find(self, scene_id: str) -> tuple[EngineScene, scene_pb2.Scene]:
        if scene_id not in self._scenes:
            raise NotFound(f"scene {scene_id!r} is not of this client")
        return self._scenes[scene_id]

    def delete_scene(self, scene_id: str) -> None:
        engine, _ = self._find(scene_id)
        del self._scenes[scene_id]
        engine.close()

    def ask_to_delete(self, scene_id: str) -> None:
        try:
            self.delete_scene(scene_id)
        except Error:
            pass

    def connect(self, patience: float = math.inf) -> Connection:
        return None  # type: ignore[return-value]  # it always is

    def reconnect(self) -> None:
        pass

    def close(self) -> None:
        pass


def client_of(server: Any, connect: dict[str, Any]) -> Client:
    """A client of this server, which may be the engine in this process."""
    return LocalClient(**connect) if isinstance(server, str) and server == LOCAL else Client(server, **connect)


def _unimplemented(what: str) -> Unimplemented:
    return Unimplemented(f"{what} needs a daemon, but server is 'local'", field="server")
