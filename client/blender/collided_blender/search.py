"""Asks the daemon: about the objects at one frame, or on their way through many."""

import numpy as np

from .findings import Findings
from .package import collided
from .refused import Refused
from .shapes import KINDS, has_faces_of, shape_of

_PATIENCE = 0.02  # seconds without an answer after which the user interface has its turn
_RECONNECT = 5  # seconds that a lost daemon is waited for, as the user interface does


def objects_to_test(context):
    """Selected objects that have faces, edges or vertices, without what shows contacts."""
    return [thing for thing in context.selected_objects if thing.type in KINDS and "collided" not in thing]


class Search:
    """Objects of a context, and what was found of them. A context manager: it closes what it has opened."""

    def __init__(self, context, client):
        self._context, self._client = context, client
        self.scene = context.scene
        self.settings = self.scene.collided
        self.objects = objects_to_test(context)
        self.findings = Findings()
        self.has_own_faces = [thing.type == "MESH" for thing in self.objects]  # in all frames: no modifier made others
        self._sessions = []
        self._shapes = []
        self._places = []  # in `objects`, of those that have something to test

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._close_sessions()
        self._client.close()

    @property
    def size(self):
        """Diagonal of the box around what was tested last; 0 if nothing was."""
        if not self._shapes:
            return 0.0
        corners = np.concatenate([shape.vertices for shape in self._shapes])
        return float(np.linalg.norm(np.ptp(corners, axis=0)))

    def in_frame(self):
        """What is near, touches or crosses at the current frame."""
        if self.settings.accuracy == "FAST" and self.settings.distance == 0:
            raise Refused("accuracy Fast needs a distance above 0")
        self._look()
        self._open([{"mode": "dcd", "kinds": ("vt", "ee", "tt"), "thickness": self.settings.distance}])
        self._take(self.scene.frame_current, self._sessions[0].step())

    def over(self, frames):
        """What meets on the way to each frame from the one before, and crosses in it. A generator, which yields the number of
        frames that are done, also while it waits for an answer."""
        for done, frame in enumerate(frames):
            self.scene.frame_set(frame)
            for session, updates in self._next():
                session.send(**updates)
            for session in self._sessions:
                while (contacts := self._received(session)) is None:
                    yield done
                self._take(frame, contacts)
            yield done + 1

    def _next(self):
        """The sessions with what each is to be sent; new ones for the first frame, and where objects come and go."""
        before, places = self._shapes, self._places
        self._look()
        if places != self._places or not self._sessions:
            crossings = {"mode": "dcd", "kinds": ("tt",)}
            if self.settings.accuracy == "FAST":  # which has no other way with triangle pairs, but asks for a distance
                crossings["accuracy"] = "guarded"
            self._open([{"mode": "ccd", "thickness": self.settings.distance}, crossings])
            return [(session, {}) for session in self._sessions]
        pairs = list(enumerate(zip(before, self._shapes)))
        replaced = {i: self._mesh(i) for i, (old, new) in pairs if not new.has_elements_of(old)}
        moved = {i: new.vertices for i, (old, new) in pairs if i not in replaced and (old.vertices != new.vertices).any()}
        edit = {"edit": collided().Edit(replaced)} if replaced else {}
        return [(session, {"positions": moved, **edit}) for session in self._sessions]

    def _look(self):
        depsgraph = self._context.evaluated_depsgraph_get()
        shapes = [shape_of(thing, depsgraph) for thing in self.objects]
        for place, (thing, shape) in enumerate(zip(self.objects, shapes)):
            self.has_own_faces[place] = self.has_own_faces[place] and has_faces_of(thing.data, shape)
        self._places = [place for place, shape in enumerate(shapes) if not shape.is_empty]
        self._shapes = [shapes[place] for place in self._places]
        if not self._shapes:
            raise Refused("no selected object has faces, edges or vertices")

    def _mesh(self, index):
        shape, settings = self._shapes[index], self.settings
        return collided().Mesh(shape.vertices, shape.triangles, edges=shape.edges, points=shape.points, name=f"object {index}",
                               self_contacts=settings.self_contacts,
                               exclude_rings=settings.exclude_rings if settings.self_contacts else 0)

    def _open(self, questions):
        self._close_sessions()
        meshes = [self._mesh(index) for index in range(len(self._shapes))]
        for question in questions:
            options = {"accuracy": self.settings.accuracy.lower(), "position_format": "f64", "reconnect_seconds": _RECONNECT, **question}
            self._sessions.append(collided().Session(meshes, server=self._client, **options))

    def _close_sessions(self):
        while self._sessions:
            self._sessions.pop().close()

    def _received(self, session):
        try:
            return session.receive(_PATIENCE)
        except collided().DeadlineExceeded:
            return None

    def _take(self, frame, contacts):
        self.findings.add(frame, contacts, dict(zip(self._places, self._shapes)))
