// The tests that features_test.py runs: the package in the folder $NEWER_PACKAGE refuses what the daemon $COLLIDED_DAEMON lacks.
// That is $NEWER_ELEMENTS, which release $NEWER_RELEASE has brought to the package's protocol.

import assert from "node:assert/strict";
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { setTimeout as pause } from "node:timers/promises";
import { pathToFileURL } from "node:url";

const { NEWER_PACKAGE, NEWER_ELEMENTS, NEWER_RELEASE } = process.env;
const load = (name) => import(pathToFileURL(join(NEWER_PACKAGE, "dist", `${name}.js`)).href);
const { Code, ContactKind, DeliveryPolicy, Report } = await load("src/index");
const { Features } = await load("src/features");
const { frameMessage } = await load("src/frame");
const { sceneSpec } = await load("src/scene");
const { ADDITIONS } = await load("src/generated/requests");
const { TWO_TRIANGLES, fall, refused, useDaemon } = await load("test/support");

const used = useDaemon();
const [floor, tip] = TWO_TRIANGLES.meshes;
const restore = () => [];
const elements = NEWER_ELEMENTS.split(" ");

/** Expects a refusal of the client's own, which names what the daemon lacks. */
async function lacking(what, call) {
  const { message } = await refused(call, Code.UNIMPLEMENTED, what);
  const daemon = `the daemon at ${used.address} is ${used.client.serverInfo.version}`;
  assert.equal(message, `${what} needs a daemon of release ${NEWER_RELEASE} or later; ${daemon}`);
}

/** The request of a scene, with fields that the package's input does not have. */
function specWith(more, ofTip = {}) {
  const spec = { ...sceneSpec(TWO_TRIANGLES), ...more };
  Object.assign(spec.meshes[1], ofTip);
  return { requestId: "", leaseSeconds: 0, spec };
}

test("the client knows what its protocol has gained", () => {
  assert.deepEqual(elements.map((name) => ADDITIONS[name]), elements.map(() => NEWER_RELEASE));
});

test("a field is refused", async () => {
  for (const method of ["createScene", "estimateScene"]) {
    await lacking("spec.mirrored", () => used.client.connection.unary(method, specWith({ mirrored: true })));
  }
  assert.deepEqual(await used.client.listScenes(), []);
});

test("a field of one of many is refused", async () => {
  await lacking("spec.meshes[1].layers", () => used.client.connection.unary("createScene", specWith({}, { layers: 2 })));
});

test("a value is refused, alone and among others", async () => {
  const kinds = [ContactKind.EDGE_EDGE, ContactKind.POINT_POINT];
  await lacking("spec.kinds[1] = CONTACT_KIND_POINT_POINT", () => used.client.createScene({ ...TWO_TRIANGLES, kinds }));
  const input = { ...TWO_TRIANGLES, report: Report.DEEPEST };
  await lacking("spec.report = REPORT_DEEPEST", () => used.client.createScene(input));
  await lacking("spec.report = REPORT_DEEPEST", () => used.client.estimateScene(input));
  await lacking("spec.report = REPORT_DEEPEST", () => used.client.session(input, { restore }));
});

test("a method is refused", async () => {
  const request = { sceneId: "a", mesh: 0, firstElement: 0 };
  await lacking("MoveScene", () => used.client.connection.unary("moveScene", request));
});

test("a watch is refused", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  await lacking("WatchScene", () => used.client.watch(scene));
  await used.client.deleteScene(scene);
});

test("an upload is refused, and leaves no scene", async () => {
  const triangles = new Uint32Array(3 << 19).map((_, i) => i % 3); // 6 MiB, more than goes with a scene
  await lacking("UploadMesh", () => used.client.createScene({ ...TWO_TRIANGLES, meshes: [floor, { ...tip, triangles }] }));
  assert.deepEqual(await used.client.listScenes(), []);
});

test("what is not set is no hindrance", async () => {
  await used.client.connection.unary("estimateScene", specWith({ mirrored: false }, { layers: 0 }));
});

test("an opening is refused", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  await lacking("open.delivery = DELIVERY_POLICY_NEWEST", () => used.client.stream(scene, { delivery: DeliveryPolicy.NEWEST }));
  const open = { sceneId: "a", window: 1, delivery: 0, resumeToken: "", isMirrored: true };
  await lacking("open.is_mirrored", () =>
    used.client.connection.encode("streamFrames", { request: { $case: "open", value: open } }),
  );
  await used.client.deleteScene(scene);
});

test("a refused opening leaves no connection", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const openFiles = () => readdirSync("/proc/self/fd").length;
  const before = openFiles();
  await lacking("open.delivery = DELIVERY_POLICY_NEWEST", () => used.client.stream(scene, { delivery: DeliveryPolicy.NEWEST }));
  await lacking("WatchScene", () => used.client.watch(scene));
  for (const giveUp = performance.now() + 5000; openFiles() > before && performance.now() < giveUp; ) await pause(10);
  assert(openFiles() <= before);
  await used.client.deleteScene(scene);
});

test("an option of a frame is refused, and the stream goes on", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const stream = await used.client.stream(scene);
  for (const call of ["detect", "send"]) {
    await lacking("frame.report = REPORT_DEEPEST", () => stream[call](fall(2, { report: Report.DEEPEST })));
  }
  assert((await stream.detect(fall(2))).done.anyContact);
  await stream.finish();
  const deepest = fall(2, { frameId: 2, report: Report.DEEPEST });
  await lacking("frame.report = REPORT_DEEPEST", () => used.client.detect(scene, deepest));
  assert((await used.client.detect(scene, fall(2, { frameId: 2 }))).done.anyContact);
  await used.client.deleteScene(scene);
});

test("an option of a frame is refused, and the session goes on", async () => {
  const session = await used.client.session(TWO_TRIANGLES, { restore });
  await lacking("frame.report = REPORT_DEEPEST", () => session.detect(fall(2, { report: Report.DEEPEST })));
  assert((await session.detect(fall(2))).done.anyContact);
  assert.deepEqual([session.reconnects, session.recreations], [0, 0]);
  await session.close();
});

test("fields of a frame and of one of its updates are refused", async () => {
  const encode = (value) => used.client.connection.encode("streamFrames", { request: { $case: "frame", value } });
  const frame = frameMessage(fall(2), 1n, sceneSpec(TWO_TRIANGLES).positionFormat);
  await lacking("frame.friction", () => encode({ ...frame, friction: 0.5 }));
  const updates = frame.updates.map((update, mesh) => ({ ...update, velocities: new Uint8Array(mesh) }));
  await lacking("frame.updates[1].velocities", () => encode({ ...frame, updates }));
});

test("a daemon that knows it is asked", async () => {
  const { encode } = used.client.connection;
  const request = encode.call({}, "createScene", specWith({ mirrored: true }));
  const features = Object.keys(ADDITIONS);
  new Features({ version: "", features }, "here").check("CreateScene", request);
  const others = features.filter((name) => name !== "collided.v1.SceneSpec.mirrored");
  const { message } = await refused(
    () => new Features({ version: "", features: others }, "here").check("CreateScene", request),
    Code.UNIMPLEMENTED,
    "spec.mirrored",
  );
  assert.match(message, /; the daemon at here is of an unknown version$/);
});

test("nothing is read of the requests to a daemon that lacks nothing", () => {
  const unreadable = Uint8Array.of(0xff);
  const check = (features) => new Features({ version: "", features }, "here").check("CreateScene", unreadable);
  check(Object.keys(ADDITIONS));
  assert.throws(() => check([]), RangeError);
});
