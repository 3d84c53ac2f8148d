import assert from "node:assert/strict";
import { test } from "node:test";
import { Code, DeliveryPolicy, type FrameOutput } from "../src/index.js";
import { TWO_TRIANGLES, fall, refused, tipAt, useDaemon } from "./support.js";

const used = useDaemon();

test("a window of frames is in flight, and outputs come in their order", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const stream = await used.client.stream(scene, { window: 3 });
  assert.equal(stream.window, 3);
  const outputs = Promise.all(Array.from({ length: 20 }, (_, i) => stream.detect(fall(1.25 + 0.25 * i))));
  for (const [i, output] of (await outputs).entries()) {
    assert.equal(output.frameId, BigInt(i + 1));
    assert(Math.abs(output.vertexTriangle.toi[0] - 1 / (1.25 + 0.25 * i)) < 1e-3);
  }
  await stream.finish();
  await used.client.deleteScene(scene);
});

test("frames are sent and received by different tasks, refused ones among them", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const stream = await used.client.stream(scene);
  const received: FrameOutput[] = [];
  const reader = (async () => {
    for await (const output of stream) received.push(output);
  })();
  const positions = tipAt(0);
  for (let i = 1; i <= 6; ++i) {
    positions.fill(i === 4 ? NaN : i);
    const sent = stream.send(i === 1 ? fall(2) : { updates: [{ mesh: 1, positions }] });
    positions.fill(NaN); // it has been encoded
    assert.equal(await sent, BigInt(i));
  }
  await stream.finish();
  await reader;
  assert.deepEqual(
    received.map(({ frameId }) => frameId),
    [1n, 2n, 3n, 4n, 5n, 6n],
  );
  assert.deepEqual(
    received.filter(({ error }) => error).map(({ frameId, error }) => [frameId, error!.field]),
    [[4n, "frame.updates[0].positions"]],
  );
  assert.throws(() => received[3].done, { code: Code.INVALID_ARGUMENT });
  assert.throws(() => received[3].check(), { code: Code.INVALID_ARGUMENT });
  await refused(() => stream.receive(), Code.FAILED_PRECONDITION, "", /as finish\(\) asked for/);
  await refused(() => stream.detect(fall(2)), Code.FAILED_PRECONDITION, "", /as finish\(\) asked for/);
  await used.client.deleteScene(scene);
});

test("LATEST_WINS tells which frames were skipped", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const stream = await used.client.stream(scene, { window: 8, delivery: DeliveryPolicy.LATEST_WINS });
  const count = 200;
  for (let i = 0; i < count; ++i) await stream.send(fall(2));
  await stream.finish();
  const outputs: FrameOutput[] = [];
  for await (const output of stream) outputs.push(output);
  assert.deepEqual(
    outputs.map(({ frameId }) => Number(frameId)),
    Array.from({ length: count }, (_, i) => i + 1),
  );
  for (const { skipped, vertexTriangle } of outputs) assert.equal(vertexTriangle.count, skipped ? 0 : 1);
  const skipped = outputs.find((output) => output.skipped);
  if (skipped) assert.throws(() => skipped.done, { code: Code.ABORTED });
});

test("receive() without a frame in flight does not wait for ever", async () => {
  const stream = await used.client.stream(await used.client.createScene(TWO_TRIANGLES));
  await refused(() => stream.receive(), Code.FAILED_PRECONDITION, "", /no frame of send\(\) in flight/);
  const detected = stream.detect(fall(2));
  await refused(() => stream.receive(), Code.FAILED_PRECONDITION, "", /no frame of send\(\) in flight/); // detect() takes its output
  await detected;
  await stream.send(fall(2));
  const received = stream.receive();
  await refused(() => stream.receive(), Code.FAILED_PRECONDITION, "", /no frame of send\(\) in flight/);
  assert.equal((await received).check().vertexTriangle.count, 1);
  await stream.finish();
});

test("finish() waits for frames that wait for a credit", async () => {
  const stream = await used.client.stream(await used.client.createScene(TWO_TRIANGLES), { window: 1 });
  const sent = Promise.all([fall(2), fall(2), fall(2)].map((frame) => stream.send(frame)));
  const outputs = Promise.all([stream.receive(), stream.receive(), stream.receive()]);
  await stream.finish();
  assert.deepEqual(await sent, [1n, 2n, 3n]);
  assert.deepEqual(
    (await outputs).map(({ frameId }) => frameId),
    [1n, 2n, 3n],
  );
});

test("a frame id that was used before leaves those that the stream gives as they are", async () => {
  const stream = await used.client.stream(await used.client.createScene(TWO_TRIANGLES));
  await stream.detect(fall(2, { frameId: 10 }));
  await refused(() => stream.detect(fall(2, { frameId: 3 })), Code.FAILED_PRECONDITION, "frame.frame_id");
  assert.equal((await stream.detect(fall(2))).frameId, 11n);
  await stream.finish();
});

test("a stream is opened as asked, or not at all", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  await refused(() => used.client.stream(scene, { window: 1.5 }), Code.INVALID_ARGUMENT, "options.window");
  await refused(() => used.client.stream(scene, { windows: 2 } as never), Code.INVALID_ARGUMENT, "options.windows");
  await refused(() => used.client.stream(scene, { window: 100_000 }), Code.RESOURCE_EXHAUSTED, "open.window");
  const first = await used.client.stream(scene);
  await refused(() => used.client.stream(scene), Code.FAILED_PRECONDITION, "open.resume_token");
  await refused(() => used.client.stream(scene, { resumeToken: "wrong" }), Code.PERMISSION_DENIED, "open.resume_token");
  await first.detect(fall(2));
  const second = await used.client.resume(scene);
  assert.equal(second.scene.lastFrameId, 1n);
  await refused(() => first.detect(fall(2)), Code.ABORTED, "open.scene_id");
  assert.equal(first.end?.error?.code, Code.ABORTED);
  assert.equal((await second.detect(fall(2))).frameId, 2n);
  await second.finish();
});

test("a stream that is cancelled, or whose scene is deleted, tells all who wait", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const cancelled = await used.client.stream(scene);
  const waiting = [cancelled.detect(fall(2)), cancelled.detect(fall(2)), cancelled.detect(fall(2))];
  cancelled.cancel();
  for (const end of await Promise.allSettled(waiting)) assert.equal(end.status, "rejected");
  await refused(() => cancelled.detect(fall(2)), Code.CANCELLED, "");
  const stream = await used.client.resume(scene);
  await used.client.deleteScene(scene);
  await refused(
    async () => {
      for await (const _ of stream);
    },
    Code.NOT_FOUND,
    "scene_id",
  );
});
