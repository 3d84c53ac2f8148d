"""A scene on a daemon."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from collided import leftovers
from collided.connection.client import Client
from collided.connection.options import ConnectOptions
from collided.errors import InvalidArgument, NotFound
from collided.in_process.client import client_of
from collided.leftovers import Leftover
from collided.frames.track import Track
from collided.layout import Layout
from collided.meshes.mesh import counted
from collided.options import SceneOptions
from collided.v1 import scene_pb2
from collided.watch import Watcher

if TYPE_CHECKING:
    from collided.session import Session

_CONNECT = {field.name for field in dataclasses.fields(ConnectOptions)}
_SCENE = {field.name for field in dataclasses.fields(SceneOptions)}


def divided(options: dict[str, Any], server: str | Client | None) -> tuple[dict[str, Any], dict[str, Any]]:
    """Those of ConnectOptions, which a Client has already, and those of SceneOptions."""
    unknown = options.keys() - _CONNECT - _SCENE
    if unknown:
        known = ", ".join(sorted(_SCENE | _CONNECT))
        raise InvalidArgument(f"{min(unknown)!r} is no option of a scene; these are {known}", field=min(unknown))
    connect = {name: value for name, value in options.items() if name in _CONNECT}
    if isinstance(server, Client) and connect:
        raise InvalidArgument(f"{min(connect)} is given with a Client, which has its own", field=min(connect))
    return connect, {name: value for name, value in options.items() if name in _SCENE}


class Resident:
    """A scene, or a set of them, where it is now: on the daemon of a client, which may be the caller's."""

    def __init__(self, client: Client, owns_client: bool, message: scene_pb2.Scene) -> None:
        self.client, self.owns_client, self.message = client, owns_client, message
        self.is_deleted = False  # from here

    @property
    def name(self) -> str:
        title = f"{self.message.spec.display_name!r}, " if self.message.spec.display_name else ""
        return f"scene {title}{self.message.scene_id} at {self.client.place}"

    def ask_to_delete(self) -> Any:
        return self.client.ask_to_delete(self.message.scene_id)

    def delete(self) -> None:
        """A daemon that is gone or does not answer is left alone: the scene's lease ends there."""
        self.is_deleted = True
        try:
            self.client.end_scene(self.message.scene_id)
        finally:
            self.disconnect()

    def disconnect(self) -> None:
        if self.owns_client:
            self.client.close()


class Scene:
    """Meshes that stay resident on a daemon, as a context manager: made at the beginning, deleted at the end.

    meshes: a mapping of names to meshes, a list of Mesh, or one mesh; a mesh is whatever `Mesh.of` takes.
    server: "host:port" or "unix:/path"; None: $COLLIDED_SERVER, or a daemon of this process's own; "local": the engine in this
        process, without a daemon. Or a Client.
    lease_seconds: without a stream or a call for so long the daemon deletes the scene; 0: its default.
    options: those of SceneOptions, and, without a Client, of ConnectOptions.

    Raises InvalidArgument for bad meshes and options, ResourceExhausted past the daemon's limits.
    """

    def __init__(self, meshes: Any, *, server: str | Client | None = None, lease_seconds: float = 0.0,
                 **options: Any) -> None:
        connect, scene = divided(options, server)
        asked = SceneOptions(**scene)
        layout = Layout.of(meshes, asked.exclude)
        # For good: after an edit another one might follow from the meshes, which a new scene must not have.
        self.options = dataclasses.replace(asked, position_format=asked.format(layout).name)
        self.track = Track(layout, self.options)
        self.lease_seconds = lease_seconds
        self._process = os.getpid()
        self.client = server if isinstance(server, Client) else client_of(server, connect)
        message = self.client.create_scene(self.track.layout, self.options, lease_seconds)
        self._resident = Resident(self.client, not isinstance(server, Client), message)
        self._leftover = leftovers.watch(self, Leftover("Scene", [], self._resident))

    @property
    def message(self) -> scene_pb2.Scene:
        """The scene as the daemon created it."""
        return self._resident.message

    @property
    def id(self) -> str:
        """The daemon's id of the scene; another one once the scene was created again."""
        return self.message.scene_id

    @property
    def name(self) -> str:
        """The scene's display name, id and daemon, as messages show them."""
        return self._resident.name

    @property
    def layout(self) -> Layout:
        """Meshes as of the last answered frame, and how their features are numbered."""
        return self.track.layout

    def refresh(self) -> scene_pb2.Scene:
        """The scene's state and memory, as the daemon has it now; restarts the lease."""
        return self.client.get_scene(self.id)

    def create_again(self) -> None:
        """A new scene, of the same meshes, in place of one that is gone, or deleted here."""
        try:
            self.client.delete_scene(self.id)
        except NotFound:
            pass
        self._resident.message = self.client.create_scene(self.track.creatable, self.options, self.lease_seconds)
        self._resident.is_deleted = False

    def move(self) -> None:
        """A new scene, of the same meshes, on another daemon, as this one's stops. One try; this one stays if it fails."""
        old = self.id
        self._resident.message = self.client.create_scene(self.track.creatable, self.options, self.lease_seconds, tries=1)
        self.client.try_delete(old)

    def session(self, **options: Any) -> Session:
        """A Session on this scene, with its options; one at a time."""
        from collided.session import Session  # which makes scenes itself

        return Session(self, **options)

    def watch(self, **options: Any) -> Watcher:
        """A Watcher of the frames that anyone sends to this scene, with its options."""
        return Watcher(self.client, self.id, **options)

    def close(self) -> None:
        """Deletes the scene, and ends the connection unless it was the caller's.

        A daemon that is gone or does not answer is left alone: the scene's lease ends there. A process that was forked from the
        scene's leaves everything to that.
        """
        if os.getpid() != self._process:
            return
        self._leftover.take()
        self._resident.delete()

    def left_by(self, kind: str, streams: Sequence[Callable[[], object]]) -> Leftover:
        """Hands the scene over to an object of this kind: the leftover of its streams and of the scene."""
        self._leftover.take()
        return Leftover(kind, streams, self._resident)

    def give_up(self, error: BaseException) -> None:
        """Deletes the scene of an object that could not be made. After an interrupt nothing waits."""
        if isinstance(error, Exception):
            self.close()
        else:
            leftovers.abandon(self._leftover)

    def __repr__(self) -> str:
        state = "closed" if self._resident.is_deleted else counted(sum(1 for _ in self.layout.present()), "mesh")
        return f"<Scene {self.id} at {self.client.place}: {state}>"

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
