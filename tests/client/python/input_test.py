#!/usr/bin/env python3
"""Bad input of every kind: what is wrong is named, with its value and its limit, and nothing goes wrong afterwards."""

import math
import types
import warnings
from functools import partial
from unittest import mock

from support import DAEMON, FLOOR, ONE, STREAMS, TIP, Case, Daemon, lowered, main, meshes, np

import collided
from collided.v1 import scene_pb2

BAD = collided.InvalidArgument


def called(call):
    """Names of the calls that a spy on Client.call has seen; it calls itself with a channel."""
    return [arguments.args[0] for arguments in call.call_args_list if len(arguments.args) < 5]


ILL_TYPED = (1, -1, 1.5, math.nan, 2**70, "x", b"x", True, [1], [None], ["x"], (1, 2), {}, {"a": 1}, object(), np.zeros(3), [[1, 2]])


class IllTyped(Case):
    """Whatever an argument is given, it is taken, or refused with an error that names it; nothing else is raised."""

    def check(self, name, call):
        for value in ILL_TYPED:
            with self.subTest(name, value=repr(value)):
                try:
                    made = call(**{name: value})
                except collided.Error as error:
                    self.assertIn(name, f"{error} {error.field if isinstance(error, BAD) else ''}")
                else:
                    getattr(made, "close", int)()

    def test_scenes_and_meshes(self):
        for name in collided.SceneOptions.__dataclass_fields__:
            self.check(name, collided.SceneOptions)
        for name in collided.Mesh.__dataclass_fields__:
            self.check(name, partial(collided.Mesh, **{key: value for key, value in (("vertices", FLOOR), ("triangles", ONE)) if key != name}))

    def test_sessions_and_sets(self):
        with collided.Client(self.server) as client:
            for name in ("window", "delivery", "transport", "output_bytes", "edit_bytes", "daemon_user", "take_over", "reconnect_seconds",
                         "lease_seconds"):
                self.check(name, partial(collided.Session, (FLOOR, ONE), server=client))
            for name in ("count", "lease_seconds", "daemon_user"):
                self.check(name, partial(collided.SceneBatch, (FLOOR, ONE), **{"count": 1} if name != "count" else {}, server=client))
            with collided.SceneBatch((FLOOR, ONE), 2, server=client) as batch:
                for name in ("start", "mode", "accuracy", "delta"):
                    self.check(name, partial(batch.step, np.array([FLOOR, FLOOR])))
                for worlds in (1, 1.5, True, {}, "x", object()):
                    with self.assertRaisesRegex(BAD, "worlds"):
                        batch.step(np.array([FLOOR, FLOOR]), worlds=worlds)

    def test_frames(self):
        session = self.session()
        session.step({"tip": TIP})
        for name in ("mode", "accuracy", "delta", "report", "ignore_separating", "advance", "limits", "trial", "from_last_fraction",
                     "edit"):
            self.check(name, partial(session.step, {"tip": TIP}))
        for name in ("V0", "V1", "F", "edges", "particles"):
            given = {"V0": TIP, "V1": TIP, "F": ONE}
            self.check(name, partial(collided.detect, **{key: value for key, value in given.items() if key != name}, server=self.server))


class Meshes(Case):
    def test_arrays_that_cannot_be(self):
        for pattern, arguments in (
                (r"triangles has shape \(3,\); it must be \(n, 3\)", {"triangles": [0, 1, 2]}),
                (r"triangles has shape \(1, 4\)", {"triangles": [[0, 1, 2, 3]]}),
                ("triangles has dtype float64; it must be of integers", {"triangles": [[0.0, 1, 2]]}),
                ("triangles has index -1; indices are from 0 to", {"triangles": [[0, 1, -1]]}),
                ("triangles has index 4294967296", {"triangles": [[0, 1, 2**32]]}),
                ("triangles has index 3; the mesh has 3 vertices", {"vertices": FLOOR, "triangles": [[0, 1, 3]]}),
                ("edges has index 7; the mesh has 3 vertices", {"vertices": FLOOR, "edges": [[0, 7]]}),
                (r"points has shape \(1, 1\)", {"points": [[0]]}),
                (r"vertices has shape \(3, 2\); it must be \(n, 3\)", {"vertices": FLOOR[:, :2], "triangles": ONE}),
                ("vertices has dtype complex", {"vertices": FLOOR + 1j, "triangles": ONE}),
                ("vertices has dtype <U1", {"vertices": [["a", "b", "c"]], "triangles": ONE}),
                ("vertices", {"vertices": [[1, 2, 3], [1, 2]], "triangles": ONE}),
                ("vertex_count is 2; elements name 3", {"triangles": ONE, "vertex_count": 2}),
                ("vertex_count is 4; vertices have 3 rows", {"vertices": FLOOR, "triangles": ONE, "vertex_count": 4}),
                ("motion is 'fast'; it must be one of deformable, static, rigid", {"triangles": ONE, "motion": "fast"}),
                ("groups is -1; it must be from 0 to 4294967295", {"triangles": ONE, "groups": -1}),
                ("exclude_rings is 9; it must be from 0 to 8", {"triangles": ONE, "exclude_rings": 9}),
                *((f"half_thickness is {bad!r}; it must be finite and at least 0", {"triangles": ONE, "half_thickness": bad})
                  for bad in (-1, float("nan"), float("inf"), "0.1", None, True)),
                ("triangles is no array of integers", {"triangles": [[0, 1, 2], [0, 1]]}),
                ("name is 5; it must be text", {"triangles": ONE, "name": 5}),
                ("collide_mask is True", {"triangles": ONE, "collide_mask": True})):
            with self.subTest(pattern):
                self.refused(BAD, pattern, collided.Mesh, **arguments)

    def test_what_no_mesh_can_be_made_of(self):
        for source in (None, 5, object(), {"faces": ONE}, types.SimpleNamespace(vertices=FLOOR)):
            with self.subTest(source=str(source)[:20]), self.assertRaises((BAD, TypeError)):
                collided.Mesh.of(source)
        self.refused(BAD, "mesh 'cloth': triangles has dtype", collided.Scene, {"cloth": (FLOOR, [[0.5, 1, 2]])})
        self.refused(BAD, "one mesh or more", collided.Scene, {})
        for name in (1, ("a",), None, "\udcff"):
            error = self.refused(BAD, "meshes is .*; it must be text", collided.Scene, {name: (FLOOR, ONE)})
            self.assertEqual(error.field, "meshes")
        error = self.refused(BAD, "triangles is no array of integers", collided.Scene, [("a", (FLOOR, ONE))])
        self.assertEqual(error.field, "triangles")


class Scenes(Case):
    def test_options_that_cannot_be(self):
        for pattern, options in (
                ("thickness is -1; it must be finite and at least 0", {"thickness": -1}),
                ("delta is nan", {"delta": math.nan}),
                ("min_separation is 'a'", {"min_separation": "a"}),
                ("mode is 'both'; it must be one of dcd, ccd, dcd_and_ccd", {"mode": "both"}),
                ("accuracy is 'sure'; it must be one of candidates, fast, guarded", {"accuracy": "sure"}),
                ("kinds is 'vt'; it must be a list", {"kinds": "vt"}),
                ("fields is 'all'; it must be a list", {"fields": "all"}),
                ("fields is 'colour'", {"fields": ["colour"]}),
                ("position_format is 'q16' and quantization_box is None", {"position_format": "q16"}),
                ("memory_budget is -5", {"memory_budget": -5}),
                ("memory_budget is True", {"memory_budget": True}),
                (r"expected_contacts is 4294967296; it must be from 0 to 2\^32 - 1", {"expected_contacts": 1 << 32}),
                ("'walls' is not in the scene", {"exclude": [("tip", "walls")]}),
                ("is no pair", {"exclude": ["tip"]}),
                ("'thicknes' is no option of a scene", {"thicknes": 1}),
                ("window is -1", {"window": -1}),
                ("transport is 'pigeon'; it must be one of auto, shared_memory, grpc", {"transport": "pigeon"}),
                ("delivery is 'never'", {"delivery": "never"}),
                (f"thickness is 1{'0' * 400}; it must be finite", {"thickness": 10**400}),
                ("kinds is 5; it must be a list", {"kinds": 5}),
                (r"kinds is \['vt'\]; it must be one of", {"kinds": [["vt"]]}),
                ("exclude is 5; it must be a list", {"exclude": 5}),
                ("device is 5; it must be text", {"device": 5}),
                ("part_devices is 5; it must be text", {"part_devices": [5]}),
                ("display_name is 5; it must be text", {"display_name": 5}),
                (r"display_name is '\\ud800'; it must be text", {"display_name": "\ud800"}),
                ("token is 5; it must be text", {"token": 5}),
                ("tls_ca is 5; it must be text", {"tls_ca": 5}),
                ("patience is 'a'; it must be seconds", {"patience": "a"}),
                ("deadline is 0; it must be above 0", {"deadline": 0}),
                ("server is 5; it must be text", {"server": 5}),
                ("server is b'unix:a'; it must be text", {"server": b"unix:a"}),
                (r"server is '\\ud800'; it must be text", {"server": "\ud800"}),
                ("server is ''; it must be 'host:port' or 'unix:/path'", {"server": ""}),
                ("reconnect_seconds is 'a'; it must be seconds, at least 0", {"reconnect_seconds": "a"}),
                ("reconnect_seconds is None", {"reconnect_seconds": None}),
                ("reconnect_seconds is nan", {"reconnect_seconds": math.nan}),
                ("reconnect_seconds is -1", {"reconnect_seconds": -1}),
                ("token has a character", {"token": "a b"}),
                ("tls_ca is empty", {"tls_server_name": "a"}),
                ("go together", {"tls_key": "a"})):
            with self.subTest(pattern):
                self.assertIn(self.refused(BAD, pattern, self.session, None, **options).field,
                              {*options, "quantization_box", "mesh", "excluded_meshes", "tls_ca"})

    def test_nothing_is_created_for_options_that_cannot_be(self):
        with collided.Client(self.server) as client:
            self.refused(BAD, "reconnect_seconds", collided.Session, meshes(), server=client, reconnect_seconds=math.nan)
            self.assertEqual(client.scenes(), [])

    def test_ids_of_scenes_are_text(self):
        with collided.Client(self.server) as client:
            for call in (client.delete_scene, client.get_scene, lambda scene: client.get_mesh(scene, 0)):
                self.assertEqual(self.refused(BAD, "scene_id is 5; it must be text", call, 5).field, "scene_id")

    def test_a_scene_whose_id_no_daemon_makes_is_not_found(self):
        with collided.Client(self.server) as client:
            for name in ("\u00e4", "a b", "a\nb", ""):
                self.refused(collided.NotFound, "", client.get_scene, name)

    def test_times_without_an_end_are_none(self):
        for seconds in (math.inf, 1e300, 10**400):
            with collided.Client(self.server, deadline=seconds, patience=seconds) as client:
                self.assertEqual(client.scenes(), [])
                for transport in (*STREAMS, "calls"):
                    with collided.Session(meshes(), server=client, transport=transport) as session:
                        self.expect_hit(session.step({"tip": lowered(2)}), 2)
                    with collided.SceneBatch(meshes(), np.int64(2), server=client, transport=transport) as batch:
                        self.assertEqual(len(batch.step(np.stack([lowered(2)] * 2)).all), 0)

    def test_what_the_daemon_refuses_names_its_field(self):
        error = self.refused(BAD, "EXACT", self.session, mode="ccd", kinds=["tt"], accuracy="exact")
        self.assertEqual(error.code, "INVALID_ARGUMENT")
        self.assertTrue(error.field.startswith("spec."), error.field)
        error = self.refused(collided.ResourceExhausted, "window", self.session, window=1000, transport="shared_memory")
        self.refused(collided.ResourceExhausted, "budget", self.session, memory_budget=1)

    def test_small_meshes_go_with_the_scene_and_large_ones_alone(self):
        small = {f"box {i}": collided.Mesh(TIP, ONE.repeat(12, axis=0)) for i in range(300)}
        large = {name: collided.Mesh(TIP, ONE.repeat(count, axis=0)) for name, count in
                 (("first", 349_000), ("last", 100_000), ("last but one", 349_525))}  # 4.2, 1.2 and 4.2 MB
        for meshes, uploads in ((small, 0), ({"first": large["first"], **small, **large}, 2)):
            with (collided.Client(self.server) as client, mock.patch.object(client, "call", wraps=client.call) as call,
                  mock.patch.object(client, "_upload", wraps=client._upload) as upload):
                for make in (collided.Scene, collided.Session, partial(collided.SceneBatch, count=2)):
                    call.reset_mock(), upload.reset_mock()
                    with make(meshes, server=client) as made:
                        names = called(call)
                        self.assertEqual((upload.call_count, names.count("CreateScene") + names.count("CreateScenes")),
                                         (uploads, 1))
                        message = made.scene.message if make is collided.Session else made.message
                        self.assertEqual([mesh.triangle_count for mesh in message.spec.meshes],
                                         [len(mesh.triangles) for mesh in meshes.values()])
                        if make is collided.Session:  # as after the loss of a daemon
                            upload.reset_mock()
                            made.scene.create_again()
                            self.assertEqual(upload.call_count, uploads)

    def test_uploads_go_together_and_one_by_one_where_few_calls_may_be_open(self):
        strip = np.arange(100_000)[:, None] + [0, 1, 2]  # 1.2 MB, three chunks
        sent = {f"mesh {i}": collided.Mesh(triangles=np.roll(strip, i, axis=1)) for i in range(10)}
        for streams in (1, 64):
            daemon = Daemon(str(DAEMON), "--max-streams-per-client", str(streams))
            self.addCleanup(daemon.kill)
            with (collided.Client(daemon.address) as client, mock.patch.object(client, "_upload", wraps=client._upload) as upload,
                  collided.Scene(sent, server=client) as scene):
                self.assertEqual(scene.message.state, scene_pb2.SCENE_STATE_READY)
                (self.assertEqual if streams == 64 else self.assertGreater)(upload.call_count, 7)  # 3 are in CreateScene
                for i, mesh in enumerate(sent.values()):
                    np.testing.assert_array_equal(client.get_mesh(scene.id, i).triangles, mesh.triangles)

    def test_a_message_keeps_within_half_of_the_daemons_limit(self):
        edges = collided.Mesh(TIP, edges=np.array([[0, 1]]).repeat(60_000, axis=0))  # 480 kB of 1 MiB
        for count, uploads in ((3_000, 0), (5_000, 1)):  # 36 and 60 kB
            daemon = Daemon(str(DAEMON), "--max-message-mb", "1")
            self.addCleanup(daemon.kill)
            with collided.Client(daemon.address) as client, mock.patch.object(client, "_upload", wraps=client._upload) as upload:
                with collided.Scene({"hair": edges, "tip": collided.Mesh(TIP, ONE.repeat(count, axis=0))}, server=client) as scene:
                    self.assertEqual(upload.call_count, uploads)
                    self.assertEqual(len(client.get_mesh(scene.id, 1).triangles), count)

    def test_a_chunk_fits_in_the_smallest_message(self):
        daemon = Daemon(str(DAEMON), "--max-message-mb", "1")
        self.addCleanup(daemon.kill)
        many = np.arange(90_000)[:, None] % 5000 + [0, 1, 2]  # 1.08 MB
        with collided.Client(daemon.address) as client, collided.Scene(collided.Mesh(triangles=many), server=client) as scene:
            np.testing.assert_array_equal(client.get_mesh(scene.id, 0).triangles, many)

    def test_triangles_that_are_refused_name_their_mesh(self):
        for before, field in ((1, "spec.meshes[1].triangles[1]"), (400_000, "triangles[400000]")):  # inline; 4.8 MB are not
            twice = {"floor": collided.Mesh(FLOOR, ONE), "tip": collided.Mesh(TIP, np.vstack([ONE] * before + [[[1, 1, 2]]]))}
            error = self.refused(collided.InvalidArgument, r"triangles\[\d+\] has a corner twice: 1 1 2, in mesh (1 \()?\"tip\"",
                                 self.session, twice)
            self.assertEqual(error.field, field)

    def test_empty_meshes_are_refused(self):
        for empty in (collided.Mesh(np.empty((0, 3)), np.empty((0, 3), int)), collided.Mesh(FLOOR)):
            self.refused(BAD, "", self.session, {"empty": empty})

    def test_nobody_answers(self):
        self.refused(collided.Unavailable, "no daemon answers at unix:/nowhere/socket", collided.Scene, meshes(),
                     server="unix:/nowhere/socket", patience=0.2)
        self.refused(ConnectionError, "127.0.0.1:1", collided.Scene, meshes(), server="127.0.0.1:1", patience=0.2)


class Frames(Case):
    def test_frames_that_cannot_be_are_refused_before_they_are_sent(self):
        for transport in STREAMS:
            session = self.session(transport=transport)
            session.step()
            for pattern, arguments, options in (
                    (r"positions\['tip'\] has shape \(2, 3\)|has 2 rows; it must have 3", ({"tip": TIP[:2]},), {}),
                    (r"positions\['tip'\] has shape \(9,\)", ({"tip": TIP.ravel()},), {}),
                    ("has dtype bool", ({"tip": TIP > 0},), {}),
                    ("has dtype object", ({"tip": TIP.astype(object)},), {}),
                    ("has dtype datetime64", ({"tip": TIP.astype("M8[s]")},), {}),
                    ("mesh 'tap' is not in the scene, which has 'floor', 'tip'", ({"tap": TIP},), {}),
                    ("mesh is 2; it must be a name, or an index below 2", ({2: TIP},), {}),
                    ("mesh is -1", ({-1: TIP},), {}),
                    ("positions names mesh 1 twice: 'tip' and 1", ({"tip": TIP, 1: TIP},), {}),
                    ("start names mesh 1 twice: 1 and 'tip'", ({"tip": TIP}, {1: TIP, "tip": TIP}), {}),
                    ("start names mesh 1", (None, {"tip": TIP}), {}),
                    (r"start\['tip'\] has 1 rows", ({"tip": TIP}, {"tip": TIP[:1]}), {}),
                    ("is a pose, and the mesh's motion is 'deformable'", ({"tip": collided.Rigid(np.eye(4))},), {}),
                    (r"indices\[1\] is 0, after 1; they must ascend", ({"tip": collided.Sparse([1, 0], TIP[:2])},), {}),
                    ("must ascend", ({"tip": collided.Sparse([1, 1], TIP[:2])},), {}),
                    ("indices has index 3; the mesh has 3", ({"tip": collided.Sparse([3], TIP[:1])},), {}),
                    ("indices has index -1", ({"tip": collided.Sparse([-1], TIP[:1])},), {}),
                    ("positions has 3 rows; it must have 1", ({"tip": collided.Sparse([0], TIP)},), {}),
                    ("from_last_fraction is 1.5", (), {"from_last_fraction": 1.5}),
                    ("delta is -1", (), {"delta": -1}),
                    ("report is 'some'", (), {"report": "some"}),
                    ("'advnce' is no option of a frame", (), {"advnce": True}),
                    ("edit is 5; it must be an Edit", (), {"edit": 5}),
                    (r"edit is Edit\(meshes=5.*; it must be an Edit, with a mapping", (), {"edit": collided.Edit(5)}),
                    ("edit.exclude is 5; it must be a list", (), {"edit": collided.Edit(exclude=5)}),
                    ("edit.meshes is .*; it must be text", (), {"edit": collided.Edit({"\ud800": (FLOOR, ONE)})}),
                    ("timeout is 'x'; it must be seconds, at least 0", (), {"timeout": "x"}),
                    ("timeout is nan", (), {"timeout": math.nan}),
                    ("timeout is -1", (), {"timeout": -1}),
                    ("edit.meshes has 9", (), {"edit": collided.Edit({9: None})})):
                with self.subTest(pattern, transport=transport):
                    self.refused(ValueError, pattern, session.step, *arguments, **options)
            self.expect_hit(session.step({"tip": lowered(2)}), 2)
            self.assertEqual((session.reconnects, session.in_flight), (0, 0))

    def test_numbers_that_cannot_be_are_refused_by_the_daemon_and_the_session_goes_on(self):
        for transport in (*STREAMS, "calls"):
            session = self.session(transport=transport)
            for bad in (np.nan, np.inf, 3e38):
                wrong = lowered(1)
                wrong[1, 2] = bad
                error = self.refused(BAD, "vertex 1|updates", session.step, {"tip": wrong})
                self.assertEqual((error.field, error.frame_id), ("frame.updates[0].positions", session._stream.sent))
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                self.refused(BAD, "", session.step, {"tip": lowered(1).astype(float) * 1e300})
            self.expect_hit(session.step({"tip": lowered(2)}), 2)
            session.close()

    def test_a_refused_frame_comes_in_its_turn_and_the_others_are_answered(self):
        for transport in STREAMS:
            session = self.session(window=3, transport=transport)
            wrong = lowered(1)
            wrong[0] = np.nan
            for positions in (lowered(2), wrong, TIP):
                session.send({"tip": positions})
            self.expect_hit(session.receive(), 2)
            self.assertEqual(self.refused(BAD, "", session.receive).frame_id, 2)
            self.assertEqual(session.receive().frame_id, 3)
            np.testing.assert_array_equal(session.positions["tip"], TIP)

    def test_order_of_calls(self):
        session = self.session()
        self.refused(collided.FailedPrecondition, "no frame in flight", session.receive)
        session.send({"tip": lowered(2)})
        self.refused(BAD, "timeout is nan", session.receive, math.nan)
        self.refused(collided.FailedPrecondition, "receive them first", session.step, {"tip": TIP})
        session.receive()
        self.refused(BAD, "static", session.step, {"floor": FLOOR})
        session.close()
        session.close()
        self.refused(collided.FailedPrecondition, "closed", session.step, {"tip": TIP})

    def test_detect_names_its_own_arguments(self):
        for pattern, arguments in (("V1 has 2 rows; it must have 3", (TIP, TIP[:2], ONE)), ("V0 has shape", (5, TIP, ONE)),
                                   ("vertex_count is 3; elements name 10", (TIP, TIP, [[0, 1, 9]])),
                                   ("no triangles, edges or particles", (TIP, TIP))):
            self.refused(ValueError, pattern, collided.detect, *arguments, server=self.server)
        for mode in ("dcd", "x", 5):
            error = self.refused(BAD, "mode is .*; detect.. is always 'ccd'", collided.detect, TIP, TIP, ONE, mode=mode)
            self.assertEqual(error.field, "mode")
        self.refused(BAD, "mode is 'ccd'.* proximity.. 'dcd'", collided.proximity, TIP, ONE, thickness=1, mode="ccd")
        self.refused(BAD, "NaN|nan|finite", collided.detect, TIP, TIP * np.nan, ONE, server=self.server)


class Limits(Case):
    options = ("--max-message-mb", "1")

    def test_a_message_beyond_the_limit_is_refused_and_nothing_is_lost(self):
        many = np.zeros((90_000, 3), "<f4")
        session = self.session({"many": collided.Mesh(triangles=ONE, vertex_count=len(many))}, transport="grpc",
                               position_format="f32")
        for _ in range(2):
            error = self.refused(collided.ResourceExhausted, "frame has 1080.* bytes; the daemon's limit", session.step, many)
            self.assertEqual((error.field, session.in_flight, session.reconnects), ("frame", 0, 0))
        near = self.session({"many": collided.Mesh(many, ONE)})  # shared memory has no such limit
        self.assertEqual(len(near.step(many)), 0)
        far = self.session({"many": collided.Mesh(many, ONE)}, transport="grpc")
        self.refused(collided.ResourceExhausted, "frame has", far.step, collided.Sparse([0], many[:1]))


if __name__ == "__main__":
    main()
