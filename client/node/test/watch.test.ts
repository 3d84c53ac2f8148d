import assert from "node:assert/strict";
import { test } from "node:test";
import { Code, type WatchedFrame } from "../src/index.js";
import { FLOOR, TWO_TRIANGLES, fall, refused, tipAt, useDaemon } from "./support.js";

const used = useDaemon();

test("a watcher sees each frame, its first contacts and positions", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const watcher = await used.client.watch(scene, { maxContactsPerKind: 1, positionMeshes: [1, 0], vertexStride: 2 });
  assert.deepEqual([watcher.scene.sceneId, watcher.vertexStride], [scene.sceneId, 2]);
  const stream = await used.client.stream(scene);
  const sent = await stream.detect(fall(2));
  const seen = await watcher.receive();
  assert.deepEqual(seen.vertexTriangle, sent.vertexTriangle);
  assert.deepEqual([seen.frameId, seen.skippedFrames, seen.omittedContacts, seen.editCount], [1n, 0n, 0n, 0n]);
  assert.deepEqual(
    seen.positions.map(({ mesh, vertexStride }) => [mesh, vertexStride]),
    [
      [1, 2],
      [0, 2],
    ],
  );
  const everySecond = (positions: Float32Array) => Float32Array.from([...positions.subarray(0, 3), ...positions.subarray(6)]);
  assert.deepEqual(
    seen.positions.map(({ positions }) => positions),
    [tipAt(-1), FLOOR].map(everySecond),
  );
  await stream.finish();
  const frames: WatchedFrame[] = [];
  await used.client.deleteScene(scene);
  for await (const frame of watcher) frames.push(frame);
  assert.deepEqual(frames, []);
  await refused(() => watcher.receive(), Code.NOT_FOUND, "scene_id");
});

test("a slow watcher is told what it missed, and sees the last frame", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const watcher = await used.client.watch(scene.sceneId);
  const stream = await used.client.stream(scene);
  const count = 100;
  for (let i = 0; i < count; ++i) await stream.detect(fall(2));
  let seen = 0n;
  for await (const frame of watcher) {
    seen += 1n + frame.skippedFrames;
    assert.equal(frame.vertexTriangle.count, 0);
    if (frame.frameId === BigInt(count)) break;
  }
  assert.equal(seen, BigInt(count));
  await refused(() => watcher.receive(), Code.CANCELLED, "");
  await stream.finish();
});

test("options that cannot be are refused by name", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const { client } = used;
  await refused(() => client.watch(scene, { positionMeshes: [-1] }), Code.INVALID_ARGUMENT, "options.position_meshes");
  await refused(() => client.watch(scene, { stride: 1 } as never), Code.INVALID_ARGUMENT, "options.stride");
  await refused(() => client.watch(scene, { positionMeshes: [7] }), Code.INVALID_ARGUMENT, "position_meshes[0]");
  await refused(() => client.watch("none"), Code.NOT_FOUND, "scene_id");
});
