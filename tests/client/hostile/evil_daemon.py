"""A daemon that misbehaves. Each class below is one behaviour. A client selects it by the class's name, which it sends as the
bearer token of its calls, so that one process serves all behaviours at once.

The scene is the floor and the tip of the other tests: vertex 3 meets triangle 0 at t = 0.5.
"""

import concurrent.futures
import contextlib
import socket
import struct
import tempfile
import threading
import time

import grpc
from collided.v1 import batch_pb2, collision_service_pb2 as api, contact_pb2, frame_pb2, local_pb2, scene_pb2

SERVICE = "collided.v1.CollisionService"
MOST = 2**32 - 1
PAUSE = 0.002  # of what never ends between two messages
LOST, LATE = "DATA_LOSS", "DEADLINE_EXCEEDED"
BEHAVIOURS = {}


def unpacked(count, *values, kind="I"):
    return struct.pack(f"<{count}{kind}", *values)


def hit(**changes):
    """The contact, as a chunk of one."""
    return contact_pb2.ContactChunk(**{
        "kind": contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE, "count": 1, "elements": unpacked(2, 3, 0),
        "stencils": unpacked(4, 3, 0, 1, 2), "toi": unpacked(1, 0.5, kind="d"), "distance": bytes(8),
        "weights": unpacked(2, 0.25, 0.25, kind="d"), "normals": unpacked(3, 0, 0, 1, kind="f"), "flags": b"\1", **changes})


def edge_hit(**changes):
    """Edges 0 and 3, as a chunk of one."""
    changes = {"kind": contact_pb2.CONTACT_KIND_EDGE_EDGE, "elements": unpacked(2, 0, 3), "stencils": unpacked(4, 0, 1, 3, 4), **changes}
    return hit(**changes)


def solid_hit(**changes):
    """Vertex 3 inside the floor, as if that were a solid, as a chunk of one."""
    return hit(**{"kind": contact_pb2.CONTACT_KIND_VERTEX_SOLID, "toi": b"", "distance": unpacked(1, -0.25, kind="d"), **changes})


def mesh_pairs(**changes):
    """The floor and the tip, with the vertex 3 inside the floor."""
    return contact_pb2.MeshPairs(**{"meshes": unpacked(2, 0, 1), "states": bytes([contact_pb2.MESH_PAIR_STATE_OVERLAPPING]),
                                    "inside": unpacked(2, 0, 1), "deepest": unpacked(1, 3), "depths": unpacked(1, 0.25, kind="d"),
                                    **changes})


def answer(frame_id, chunk=None, **changes):
    done = frame_pb2.FrameDone(**{"contact_count": 1, "earliest_toi": 0.5, "any_contact": True, **changes})
    done.contacts.append(chunk or hit())
    return api.StreamFramesResponse(frame_id=frame_id, done=done)


def mesh_page(first, **changes):
    return api.GetMeshResponse(**{"elements": unpacked(3, 0, 1, 2), "element_count": 1, "vertex_count": 3, **changes})


class Honest:
    """Behaves well. scenarios: the names of what a client does with it. expected: the codes with which that may end. says: what the
    error's message has."""

    scenarios, expected, says = ("stream", "session", "call", "watch", "mesh", "list"), {"ok"}, ""

    def __init_subclass__(cls):
        if not cls.__name__.startswith("Of"):  # what several have in common
            BEHAVIOURS[cls.__name__] = cls

    refusal = ""  # of streams

    def info(self, info):
        return info

    def end(self, message):
        """Returns the answer to DetectFrame."""
        return api.DetectFrameResponse(done=message.done)

    def scene(self, scene):
        return scene

    def known(self, scene):
        """The scene, as it is answered later."""
        return scene

    def opened(self, opened):
        """The first message of a stream; None: there is none."""
        return api.StreamFramesResponse(opened=opened)

    def answers(self, frame_ids, is_active):
        """Messages for the frames of a stream, as they come."""
        for frame_id in frame_ids:
            yield from self.frame(frame_id)

    def frame(self, frame_id):
        yield answer(frame_id)

    def page(self, request, scene):
        return api.ListScenesResponse(scenes=[scene])

    def mesh(self, first):
        return mesh_page(first)

    def watch(self, scene, is_active):
        yield api.WatchSceneResponse(opened=api.WatchOpened(scene=scene, vertex_stride=1))
        done = answer(1).done
        yield api.WatchSceneResponse(frame_id=1, done=done)
        wait(is_active)

    def set_answer(self, frame):
        chunk = batch_pb2.WorldContacts(begin=unpacked(3, 0, 1, 1, kind="Q"), contacts=hit())
        return [batch_pb2.SetAnswer(scene_id=frame.scene_id, frame_id=frame.frame_id, contacts=[chunk],
                                    done=answer(1).done)]


BEHAVIOURS["Honest"] = Honest


def wait(is_active):
    while is_active():
        time.sleep(0.02)


class OfStream(Honest):
    """Answers frames wrongly."""

    scenarios, expected = ("stream", "session", "call"), {LOST}
    chunk, changes = {}, {}

    def frame(self, frame_id):
        yield answer(frame_id, hit(**self.chunk), **self.changes)


class OfWaits(Honest):
    scenarios, expected = ("stream", "session"), {LATE}


# Counts and ids.


class HugeCount(OfStream):
    chunk = {"count": MOST}


class HugeCountAlone(OfStream):
    chunk = {"count": MOST, **dict.fromkeys(("elements", "stencils", "toi", "distance", "weights", "normals", "flags"), b"")}


class NoCount(OfStream):
    chunk = {"count": 0}


class HugeTotal(OfStream):
    changes = {"contact_count": 2**64 - 1}


class UnknownKind(OfStream):
    chunk = {"kind": 77}


class UnknownElement(OfStream):
    scenarios = ("stream", "session")  # a call's scene may have been edited since the client saw it
    chunk = {"elements": unpacked(2, 3, MOST)}


class UnknownVertex(UnknownElement):
    chunk = {"stencils": unpacked(4, 3, 0, 1, MOST)}


class TimeThatIsNone(OfStream):
    chunk = {"toi": unpacked(1, float("nan"), kind="d")}


class EarliestTimeThatIsNone(OfStream):
    changes = {"earliest_toi": float("nan")}


class AdvanceThatIsNone(OfStream):
    changes = {"advanced": float("inf")}


class WayThatIsNone(OfStream):
    changes = {"way": float("inf")}


class ShortenedWithoutAdvance(OfStream):
    changes = {"shortened": frame_pb2.ShortenedWays(ids=unpacked(1, 3), fractions=unpacked(1, 0.5, kind="d"))}


class LimitsThatNobodyAskedFor(OfStream):
    says = "limits"
    changes = {"advanced": 0.5, "limits": [hit()]}


class SharedWithoutMemory(OfStream):
    """Names gigabytes of shared memory where there is none."""

    def frame(self, frame_id):
        chunk = hit(elements=b"")
        chunk.shared.elements.offset, chunk.shared.elements.size = 2**63, 2**63
        yield answer(frame_id, chunk)


class NoWindow(OfStream):
    scenarios = ("stream", "session")

    def opened(self, opened):
        opened.window = 0
        return super().opened(opened)


class HugeWindow(NoWindow):
    def opened(self, opened):
        opened.window = MOST
        return Honest.opened(self, opened)


class NoScene(OfStream):
    """Creates a scene, and does not say which."""

    def scene(self, scene):
        return scene_pb2.Scene()


class OpenedWithoutSpec(OfStream):
    scenarios, expected = ("stream", "session", "watch"), {LOST, "ok"}

    def frame(self, frame_id):
        yield answer(frame_id)

    def opened(self, opened):
        opened.scene.ClearField("spec")
        return super().opened(opened)

    def watch(self, scene, is_active):
        scene.ClearField("spec")
        yield from super().watch(scene, is_active)


class CallWithoutEnd(OfStream):
    scenarios = ("call",)

    def frame(self, frame_id):
        yield answer(frame_id)

    def end(self, message):
        return api.DetectFrameResponse()


class InfoWithoutLimits(OfStream):
    expected = {"UNIMPLEMENTED", LOST, "RESOURCE_EXHAUSTED"}

    def info(self, info):
        info.ClearField("limits")
        return info


# Order, and types of answers.


class FrameThatWasNotSent(OfStream):
    scenarios = ("stream", "session")

    def frame(self, frame_id):
        yield answer(frame_id + 1000)


class OutOfOrder(FrameThatWasNotSent):
    scenarios = ("stream",)

    def answers(self, frame_ids, is_active):
        first, second = next(frame_ids), next(frame_ids)
        yield answer(second)
        yield answer(first)


class OpenedTwice(FrameThatWasNotSent):
    def frame(self, frame_id):
        yield api.StreamFramesResponse(frame_id=frame_id, opened=api.StreamOpened(window=1))


class SkippedWithoutLeave(FrameThatWasNotSent):
    """A stream without loss must answer each frame."""

    def frame(self, frame_id):
        yield api.StreamFramesResponse(frame_id=frame_id, skipped=api.FrameSkipped())


class FirstAnswerOfAnotherType(FrameThatWasNotSent):
    expected = {LOST, "INTERNAL"}

    def opened(self, opened):
        return answer(1)


class AnotherScene(FrameThatWasNotSent):
    def opened(self, opened):
        opened.scene.scene_id = "another"
        return super().opened(opened)


class CutMessage(FrameThatWasNotSent):
    expected = {LOST, "INTERNAL", "UNAVAILABLE", LATE}

    def frame(self, frame_id):
        yield answer(frame_id).SerializeToString()[:-5]


class HugeErrorText(OfStream):
    scenarios, expected = ("stream", "session"), {"INVALID_ARGUMENT"}

    def frame(self, frame_id):
        yield api.StreamFramesResponse(frame_id=frame_id, error=frame_pb2.FrameError(code=3, message="x" * (3 << 20)))


class HugeStatusText(OfStream):
    """Refuses the stream with more text than gRPC's metadata holds."""

    scenarios = ("stream", "session")
    expected = {"INVALID_ARGUMENT", "RESOURCE_EXHAUSTED", "INTERNAL", "UNAVAILABLE", "CANCELLED", "UNKNOWN", LATE}
    refusal = "x" * (1 << 20)


class EndsBeforeEachAnswer(OfStream):
    """Opens each stream, and ends it when a frame comes."""

    scenarios, expected = ("stream", "session"), {"UNAVAILABLE", LATE}

    def answers(self, frame_ids, is_active):
        next(frame_ids)
        yield from ()


# Waits.


class NeverOpens(OfWaits):
    scenarios = ("stream", "session", "watch")

    def opened(self, opened):
        return None

    def watch(self, scene, is_active):
        wait(is_active)
        yield from ()


class NeverOpensAgain(OfWaits):
    """A timeout of the caller's holds while a stream is opened again, too."""

    scenarios = ("timeouts",)
    _opened = set()  # peers' scenes

    def opened(self, opened):
        if opened.scene.scene_id in self._opened:
            return None
        self._opened.add(opened.scene.scene_id)
        return super().opened(opened)

    def answers(self, frame_ids, is_active):
        yield answer(next(frame_ids))
        next(frame_ids)


class NeverAnswers(OfWaits):
    def answers(self, frame_ids, is_active):
        wait(is_active)
        yield from ()


class NeverReads(OfWaits):
    """Takes no more of a large frame than a connection buffers."""

    scenarios = ("large",)

    def answers(self, frame_ids, is_active):
        wait(is_active)
        yield from ()


class FirstAnswerThenSilence(OfWaits):
    scenarios = ("stream",)

    def answers(self, frame_ids, is_active):
        yield answer(next(frame_ids))
        wait(is_active)


class NeverEnds(OfWaits):
    """Answers, but does not end a stream that is half closed."""

    scenarios, expected = ("stream",), {LATE, "ok"}

    def answers(self, frame_ids, is_active):
        yield from super().answers(frame_ids, is_active)
        wait(is_active)


class EndlessChunks(OfWaits):
    """Time passes, although messages come."""

    def frame(self, frame_id):
        while True:
            yield api.StreamFramesResponse(frame_id=frame_id, contacts=hit())
            time.sleep(PAUSE)


class EndlessDraining(OfWaits):
    def answers(self, frame_ids, is_active):
        while is_active():
            yield api.StreamFramesResponse(draining=api.Draining(deadline_seconds=float("inf")))
            time.sleep(PAUSE)


class EndpointThatIsSilent(OfWaits):
    """The scene's endpoint takes connections, and says nothing."""

    expected = {"UNAVAILABLE"}

    def scene(self, scene):
        scene.endpoint = SILENT.address
        return scene


class NoInfo(OfWaits):
    expected = {"UNAVAILABLE", LATE}

    def info(self, info):
        time.sleep(4)
        return info


# Advances.


class OfAdvances(Honest):
    """Answers a frame that advances per vertex. ways: what each message says was shortened; the last one is `done`."""

    scenarios, expected = ("advance",), {LOST}
    ways = (((3, 0.25),), ((4, 0.5),))

    def info(self, info):
        info.features.extend(("collided.v1.Frame.advance_mode", "collided.v1.ADVANCE_MODE_PER_VERTEX"))
        return info

    def frame(self, frame_id):
        if frame_id == 1:
            return (yield answer(frame_id))
        *messages, last = map(self.shortened, self.ways)
        for message in messages:
            yield api.StreamFramesResponse(frame_id=frame_id, shortened=message)
        yield answer(frame_id, advanced=0.25, way=0.75, shortened=last)

    def shortened(self, ways):
        ids, fractions = zip(*ways)
        return frame_pb2.ShortenedWays(ids=unpacked(len(ids), *ids), fractions=unpacked(len(ids), *fractions, kind="d"))


class HonestAdvance(OfAdvances):
    expected = {"ok"}


class HonestAdvanceInOneMessage(HonestAdvance):
    ways = (((3, 0.25), (4, 0.5)),)


class AdvanceOfAnOlderDaemon(OfAdvances):
    expected = {"UNIMPLEMENTED"}

    def info(self, info):
        return info


class ShortenedUnknownVertex(OfAdvances):
    ways = (((3, 0.25), (6, 0.5)),)


class ShortenedTwice(OfAdvances):
    ways = (((3, 0.25),), ((3, 0.25),))


class ShortenedByNothing(OfAdvances):
    ways = (((3, 0.25),), ((4, 1.0),))


class ShortenedByWhatIsNone(OfAdvances):
    ways = (((3, 0.25),), ((4, float("nan")),))


class ShortenedWithoutFractions(OfAdvances):
    def shortened(self, ways):
        return frame_pb2.ShortenedWays(ids=super().shortened(ways).ids)


# Limits of an advance.


class OfLimits(Honest):
    """Answers a frame that advances and asks for limits. limits: what each message says limits the way; the last one is in `done`."""

    scenarios, expected = ("limits",), {LOST}
    limits = (hit(), edge_hit(toi=unpacked(1, 0.75, kind="d")))

    def info(self, info):
        info.features.append("collided.v1.Frame.limits")
        return info

    def frame(self, frame_id):
        if frame_id == 1:
            return (yield answer(frame_id))
        for message in self.limits[:-1]:
            yield api.StreamFramesResponse(frame_id=frame_id, limits=message)
        yield answer(frame_id, advanced=0.25, way=0.75, limits=self.limits[-1:])


class HonestLimits(OfLimits):
    expected = {"ok"}


class LimitsOfAnOlderDaemon(OfLimits):
    expected, says = {"UNIMPLEMENTED"}, "frame.limits"

    def info(self, info):
        return info


class LimitsOfHugeCount(OfLimits):
    says = "limits."
    limits = (hit(), edge_hit(count=MOST))


class LimitsOfNoCount(OfLimits):
    says = "limits.count"
    limits = (hit(), edge_hit(count=0))


class LimitsWithoutNormals(OfLimits):
    """Limits have every array."""

    says = "limits.normals"
    limits = (hit(), edge_hit(normals=b""))


class LimitsWithoutFlags(OfLimits):
    says = "limits.flags"
    limits = (hit(flags=b""), edge_hit())


class LimitsOfShortWeights(OfLimits):
    says = "limits.weights"
    limits = (hit(weights=bytes(8)), edge_hit())


class LimitsOfTriangles(OfLimits):
    says = "limits.kind"
    limits = (hit(), edge_hit(kind=contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE, elements=unpacked(2, 0, 1)))


class LimitsOfSolids(OfLimits):
    says = "limits.kind"
    limits = (hit(), solid_hit())


class LimitsOfUnknownKind(OfLimits):
    says = "limits.kind"
    limits = (hit(kind=77), edge_hit())


class LimitsOfUnknownVertex(OfLimits):
    says = "limits.stencils"
    limits = (hit(stencils=unpacked(4, 3, 0, 1, MOST)), edge_hit())


class LimitsOfUnknownEdge(OfLimits):
    says = "limits.elements"
    limits = (hit(), edge_hit(elements=unpacked(2, 0, 6)))


class LimitsAtATimeThatIsNone(OfLimits):
    says = "limits.toi"
    limits = (hit(toi=unpacked(1, float("nan"), kind="d")), edge_hit())


class LimitsAtADistanceThatIsNone(OfLimits):
    says = "limits.distance"
    limits = (hit(distance=unpacked(1, -1.0, kind="d")), edge_hit())


# States of pairs of meshes, and vertices in solids.


class OfPairs(Honest):
    """Answers a frame with a vertex in a solid. pairs: in a message of their own. last: in `done`. sign: of the contact's distance, 0.25."""

    scenarios, expected = ("pairs",), {LOST}
    pairs, last, solid, sign = mesh_pairs(), None, solid_hit(), -0.25

    def info(self, info):
        info.features.append("collided.v1.CONTACT_FIELD_PAIR_STATES")
        return info

    def frame(self, frame_id):
        yield api.StreamFramesResponse(frame_id=frame_id, pairs=self.pairs)
        near = hit(toi=b"", distance=unpacked(1, 0.25, kind="d"), signed_distances=unpacked(1, self.sign, kind="d"))
        yield answer(frame_id, self.solid, contact_count=2, contacts=[near], pairs=self.last)


class HonestPairs(OfPairs):
    expected = {"ok"}


class PairsInTheEnd(HonestPairs):
    pairs, last = contact_pb2.MeshPairs(), mesh_pairs()


class PairsOfAnOlderDaemon(OfPairs):
    expected, says = {"UNIMPLEMENTED"}, "CONTACT_FIELD_PAIR_STATES"

    def info(self, info):
        return info


class PairsTwice(OfPairs):
    says = "pairs.meshes"
    last = mesh_pairs()


class PairsOfOneMesh(OfPairs):
    says = "pairs.meshes"
    pairs = mesh_pairs(meshes=unpacked(2, 1, 1))


class PairsOfUnknownMesh(OfPairs):
    says = "pairs.meshes"
    pairs = mesh_pairs(meshes=unpacked(2, 0, 2))


class PairsOfShortMeshes(OfPairs):
    says = "pairs.meshes"
    pairs = mesh_pairs(meshes=bytes(7))


class PairsOfManyStates(OfPairs):
    says = "pairs."
    pairs = mesh_pairs(states=bytes(9))


class PairsOfUnknownState(OfPairs):
    says = "pairs.states"
    pairs = mesh_pairs(states=b"\5")


class PairsOfNoState(OfPairs):
    says = "pairs.states"
    pairs = mesh_pairs(states=b"\0")


class PairsOfUnknownVertex(OfPairs):
    says = "pairs.deepest"
    pairs = mesh_pairs(deepest=unpacked(1, 6))


class PairsWithoutTheDeepest(OfPairs):
    says = "pairs.deepest"
    pairs = mesh_pairs(deepest=unpacked(1, MOST))


class PairsOfADepthThatIsNone(OfPairs):
    says = "pairs.depths"
    pairs = mesh_pairs(depths=unpacked(1, float("nan"), kind="d"))


class DepthOutside(OfPairs):
    says = "contacts.distance"
    solid = solid_hit(distance=bytes(8))


class DepthOfUnknownVertex(OfPairs):
    says = "contacts.elements"
    solid = solid_hit(elements=unpacked(2, 6, 0))


class SignOfAnotherDistance(OfPairs):
    says = "contacts.signed_distances"
    sign = 0.5


# Pages.


class SameTokenAgain(Honest):
    scenarios, expected = ("list",), {LOST}

    def page(self, request, scene):
        return api.ListScenesResponse(scenes=[scene], next_page_token="again")


class EmptyPages(SameTokenAgain):
    def page(self, request, scene):
        return api.ListScenesResponse(next_page_token=request.page_token + "x")


class EndlessPages(SameTokenAgain):
    expected = {LATE}

    def page(self, request, scene):
        number = int(request.page_token or 0) + 1
        scene.scene_id = f"{number:09}"
        time.sleep(PAUSE)
        return api.ListScenesResponse(scenes=[scene], next_page_token=str(number))


class EndlessElements(Honest):
    scenarios, expected = ("mesh",), {LATE}

    def mesh(self, first):
        time.sleep(PAUSE)
        return mesh_page(first, element_count=MOST)


class EmptyPageOfElements(EndlessElements):
    expected = {LOST}

    def mesh(self, first):
        return mesh_page(first, elements=b"", element_count=MOST)


class ElementOfOtherVertices(EmptyPageOfElements):
    def mesh(self, first):
        return mesh_page(first, elements=unpacked(3, 0, 1, MOST))


class EditedForEver(EndlessElements):
    expected = {"ABORTED"}

    def mesh(self, first):
        return mesh_page(first, element_count=2, edit_count=first)


# Watches.


class WatchOfAnotherType(Honest):
    scenarios, expected = ("watch",), {LOST}

    def watch(self, scene, is_active):
        yield api.WatchSceneResponse(frame_id=1, done=answer(1).done)


class WatchOfHugeCount(WatchOfAnotherType):
    chunk = {"count": MOST}

    def watch(self, scene, is_active):
        yield api.WatchSceneResponse(opened=api.WatchOpened(scene=scene))
        yield api.WatchSceneResponse(frame_id=1, done=answer(1, hit(**self.chunk)).done)


class WatchOfLimits(WatchOfAnotherType):
    """Watchers are shown none."""

    says = "limits"

    def watch(self, scene, is_active):
        yield api.WatchSceneResponse(opened=api.WatchOpened(scene=scene))
        yield api.WatchSceneResponse(frame_id=1, done=answer(1, advanced=0.5, limits=[hit()]).done)


class WatchOfUnknownVertex(WatchOfHugeCount):
    chunk = {"stencils": unpacked(4, 3, 0, 1, MOST)}


class WatchOfOddPositions(WatchOfAnotherType):
    def watch(self, scene, is_active):
        yield api.WatchSceneResponse(opened=api.WatchOpened(scene=scene))
        sample = api.VertexSample(mesh=1, vertex_stride=1, positions=bytes(13))
        yield api.WatchSceneResponse(frame_id=1, done=answer(1).done, positions=[sample])


class WatchOfUnknownMesh(WatchOfAnotherType):
    def watch(self, scene, is_active):
        yield api.WatchSceneResponse(opened=api.WatchOpened(scene=scene))
        sample = api.VertexSample(mesh=MOST, vertex_stride=1, positions=bytes(36))
        yield api.WatchSceneResponse(frame_id=1, done=answer(1).done, positions=[sample])


# Sets.


class HonestSet(Honest):
    scenarios = ("set",)


class MoreAnswersThanFrames(HonestSet):
    expected = {LOST}

    def set_answer(self, frame):
        return 2 * super().set_answer(frame)


class NoAnswers(MoreAnswersThanFrames):
    def set_answer(self, frame):
        return []


class BeginsBeyondCounts(MoreAnswersThanFrames):
    begins = (0, 1, 2**64 - 1)

    def set_answer(self, frame):
        (one,) = HonestSet.set_answer(self, frame)
        one.contacts[0].begin = unpacked(3, *self.begins, kind="Q")
        return [one]


class SetAnswerWithoutEnd(MoreAnswersThanFrames):
    def set_answer(self, frame):
        (one,) = HonestSet.set_answer(self, frame)
        one.ClearField("done")
        return [one]


class BeginsThatDescend(BeginsBeyondCounts):
    begins = (0, 2**63, 1)


class SetOfHugeCount(MoreAnswersThanFrames):
    def set_answer(self, frame):
        (one,) = HonestSet.set_answer(self, frame)
        one.contacts[0].contacts.count = MOST
        one.contacts[0].begin = unpacked(3, 0, 1, MOST, kind="Q")
        return [one]


class SetOfMoreWorlds(MoreAnswersThanFrames):
    def scene(self, scene):
        scene.worlds = MOST
        return scene


# Local sockets.


class OfLocal(Honest):
    """A daemon on this host, with a local socket. listening: connections that may wait to be taken."""

    scenarios, expected = ("local",), {LOST}
    listening = 128

    def info(self, info):
        info.local_socket = LocalSocket(self).path
        return info

    def local(self, peer):
        """Serves a connection."""
        request = local_pb2.LocalRequest.FromString(peer.recv(1 << 16)).open.open
        opened = api.StreamOpened(scene=scene_pb2.Scene(scene_id=request.scene_id), window=request.window)
        peer.send(local_pb2.LocalResponse(frame=api.StreamFramesResponse(opened=opened)).SerializeToString())
        while packet := peer.recv(1 << 16):
            for message in self.frame(local_pb2.LocalRequest.FromString(packet).frame.frame_id):
                peer.send(local_pb2.LocalResponse(frame=message).SerializeToString())
        peer.send(local_pb2.LocalResponse(closed=local_pb2.LocalClosed()).SerializeToString())


class HonestLocal(OfLocal):
    expected = {"ok"}


class LocalSocketThatTakesNobody(OfLocal):
    expected, listening = {"UNAVAILABLE"}, 0


class LocalSocketThatNeverAnswers(OfLocal):
    expected = {LATE}

    def local(self, peer):
        time.sleep(5)


class LocalGarbage(OfLocal):
    def local(self, peer):
        peer.recv(1 << 16)
        peer.send(b"\xff\xff\xff")


class RangeBeyondTheMemory(OfLocal):
    offset = 2**64 - 8

    def frame(self, frame_id):
        chunk = hit(elements=b"", count=MOST)
        chunk.shared.elements.offset, chunk.shared.elements.size = self.offset, 8 * MOST
        yield answer(frame_id, chunk)


class RangeLargerThanTheMemory(RangeBeyondTheMemory):
    offset = 0


class MemoryOfMoreThanThereIs(OfLocal):
    expected = {LOST, "RESOURCE_EXHAUSTED"}

    def known(self, scene):
        for mesh in scene.spec.meshes:
            mesh.vertex_count = MOST
        scene.worlds = MOST
        return scene


# An endpoint that takes a while.


class EndpointThatComesLater(Honest):
    """Its connections are refused at first, as by a proxy that is being started."""

    scenarios = ("later",)

    def scene(self, scene):
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        scene.endpoint = f"127.0.0.1:{port}"
        threading.Timer(0.7, lambda: EvilDaemon(port)).start()
        return scene


class LocalSocket:
    """A listener of one connection."""

    def __init__(self, behaviour):
        self._behaviour = behaviour
        self._folder = tempfile.TemporaryDirectory()
        self.path = f"{self._folder.name}/socket"
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._listener.bind(self.path)
        self._listener.listen(behaviour.listening)
        if behaviour.listening:
            threading.Thread(target=self._serve, daemon=True).start()
        else:
            self._waiting = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            self._waiting.connect(self.path)  # the only one that may wait

    def _serve(self):
        with contextlib.suppress(OSError):
            self._behaviour.local(self._listener.accept()[0])


class Silent:
    """A TCP port that takes connections, and says nothing."""

    def __init__(self):
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._taken = []
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._take, daemon=True).start()

    def _take(self):
        while True:
            self._taken.append(self._listener.accept()[0])


SILENT = Silent()


class EvilDaemon:
    """Serves at `address`."""

    _specs = {}  # of all of them

    def __init__(self, port=0):
        self._server = grpc.server(concurrent.futures.ThreadPoolExecutor(192))
        unary = {"GetServerInfo": (self._info, api.GetServerInfoRequest), "CreateScene": (self._create, api.CreateSceneRequest),
                 "CreateScenes": (self._create, batch_pb2.CreateScenesRequest), "GetScene": (self._get, api.GetSceneRequest),
                 "DeleteScene": (self._delete, api.DeleteSceneRequest), "ListScenes": (self._list, api.ListScenesRequest),
                 "GetMesh": (self._mesh, api.GetMeshRequest), "DetectFrame": (self._frame, api.DetectFrameRequest),
                 "DetectBatch": (self._batch, batch_pb2.DetectBatchRequest)}
        handlers = {name: grpc.unary_unary_rpc_method_handler(function, kind.FromString, _bytes)
                    for name, (function, kind) in unary.items()}
        handlers["StreamFrames"] = grpc.stream_stream_rpc_method_handler(self._stream, api.StreamFramesRequest.FromString, _bytes)
        handlers["WatchScene"] = grpc.unary_stream_rpc_method_handler(self._watch, api.WatchSceneRequest.FromString, _bytes)
        self._server.add_generic_rpc_handlers((grpc.method_handlers_generic_handler(SERVICE, handlers),))
        self.address = f"127.0.0.1:{self._server.add_insecure_port(f'127.0.0.1:{port}')}"
        self._server.start()

    def close(self):
        self._server.stop(None)

    def _info(self, request, context):
        limits = api.ServerLimits(max_message_bytes=64 << 20, max_window=16)
        return _of(context).info(api.GetServerInfoResponse(version="1", limits=limits))

    def _create(self, request, context):
        behaviour = _of(context)
        scene = scene_pb2.Scene(scene_id=f"scene-of-{type(behaviour).__name__}", spec=request.spec, resume_token="token",
                                state=scene_pb2.SCENE_STATE_READY, lease_seconds=60)
        for mesh in scene.spec.meshes:
            mesh.triangles = b""
        self._specs[scene.scene_id] = scene
        if isinstance(request, batch_pb2.CreateScenesRequest):
            scene.worlds = request.count
            return batch_pb2.CreateScenesResponse(scenes=behaviour.scene(scene))
        return api.CreateSceneResponse(scene=behaviour.scene(scene))

    def _scene(self, scene_id):
        scene = scene_pb2.Scene()
        scene.CopyFrom(self._specs[scene_id])
        return scene

    def _get(self, request, context):
        return api.GetSceneResponse(scene=_of(context).known(self._scene(request.scene_id)))

    def _delete(self, request, context):
        return api.DeleteSceneResponse()

    def _list(self, request, context):
        return _of(context).page(request, scene_pb2.Scene(scene_id="scene"))

    def _mesh(self, request, context):
        return _of(context).mesh(request.first_element)

    def _frame(self, request, context):
        (message,) = _of(context).frame(request.frame.frame_id)
        out = _of(context).end(message)
        out.contacts.extend(message.done.contacts)
        if out.HasField("done"):
            del out.done.contacts[:]
        return out

    def _batch(self, request, context):
        return batch_pb2.DetectBatchResponse(answers=_of(context).set_answer(request.frames[0]))

    def _stream(self, requests, context):
        behaviour, opening = _of(context), next(requests).open
        if "set" in behaviour.scenarios:
            context.abort(grpc.StatusCode.RESOURCE_EXHAUSTED, "no streams of sets")
        if behaviour.refusal:
            context.abort(grpc.StatusCode.INVALID_ARGUMENT, behaviour.refusal)
        first = behaviour.opened(api.StreamOpened(scene=self._scene(opening.scene_id), window=opening.window or 2))
        if first is None:
            wait(context.is_active)
            return
        yield first
        yield from behaviour.answers((request.frame.frame_id for request in requests), context.is_active)

    def _watch(self, request, context):
        yield from _of(context).watch(self._scene(request.scene_id), context.is_active)


def _bytes(message):
    return message if isinstance(message, bytes) else message.SerializeToString()


def _of(context):
    token = dict(context.invocation_metadata()).get("authorization", "Bearer Honest").removeprefix("Bearer ")
    return BEHAVIOURS[token]()
