import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { after, test } from "node:test";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import {
  Code,
  DetectionMode,
  type FrameInput,
  type FrameOutput,
  type FrameStream,
  MeshMotion,
  type MeshUpdateInput,
  OwnDaemon,
  type RigidMatrix,
  type SceneInput,
  connect,
} from "../src/index.js";
import { Proxy } from "./proxy.js";
import { FLOOR, TWO_TRIANGLES, refused, tipAt } from "./support.js";

const [floor, tip] = TWO_TRIANGLES.meshes;
const FALLING: SceneInput = { ...TWO_TRIANGLES, meshes: [{ ...floor, motion: MeshMotion.STATIC }, tip] };
const TURNING: SceneInput = { ...FALLING, meshes: [FALLING.meshes[0], { ...tip, motion: MeshMotion.RIGID }] };
const BOTH: SceneInput = { ...FALLING, mode: DetectionMode.DCD_AND_CCD, minSeparation: 1e-3 };
const FRAMES = 12;

/** The tip goes up and down through the floor: each frame's contacts depend on where the last one left it. */
const heightAt = (frame: number) => (frame % 2 ? 0.9 : -1) * (1 + frame / 10);
const updateAt = (scene: SceneInput, frame: number): MeshUpdateInput =>
  scene === TURNING
    ? { mesh: 1, transform: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, heightAt(frame) - heightAt(0)] }
    : { mesh: 1, positions: tipAt(heightAt(frame)) };
const FIRST: FrameInput = {
  updates: [
    { mesh: 0, positions: FLOOR },
    { mesh: 1, positions: tipAt(heightAt(0)) },
  ],
};
const frameAt = (scene: SceneInput, frame: number): FrameInput => (frame === 0 ? FIRST : { updates: [updateAt(scene, frame)] });

/** Contacts of each frame; `disturb` is called while a frame is being sent, if that frame is in flight. */
async function play(scene: SceneInput, address: string, disturb: (frame: number) => unknown = () => {}) {
  const client = await connect(address);
  let at = 0;
  const session = await client.session(scene, { restore: () => [updateAt(scene, at - 1)], giveUpSeconds: 30 });
  const outputs: FrameOutput[] = [];
  for (; at < FRAMES; ++at) {
    const answer = session.detect(frameAt(scene, at));
    await disturb(at);
    outputs.push(await answer);
  }
  await session.close();
  assert.deepEqual(await client.listScenes().catch(() => []), []);
  await client.close();
  return { session, contacts: outputs.map(({ vertexTriangle, edgeEdge }) => ({ vertexTriangle, edgeEdge })) };
}

const proxy = new Proxy();
const HASTY = ["--threads", "1", "--grace-seconds", "0"];
let daemon = await OwnDaemon.start(HASTY);
await proxy.open(daemon.address);
after(async () => {
  proxy.close();
  await daemon.stop();
});

for (const [name, scene] of Object.entries({ FALLING, TURNING, BOTH })) {
  test(`what is lost is restored, and contacts are the same (${name})`, async () => {
    const undisturbed = await play(scene, daemon.address);
    assert(undisturbed.contacts.filter(({ vertexTriangle }) => vertexTriangle.count > 0).length >= FRAMES - 1);
    assert.deepEqual([undisturbed.session.reconnects, undisturbed.session.recreations], [0, 0]);

    const cut = await play(scene, proxy.address, (frame) => frame % 3 === 1 && proxy.cut());
    assert.deepEqual(cut.contacts, undisturbed.contacts);
    assert.deepEqual([cut.session.reconnects, cut.session.recreations], [4, 0]);

    const killed = await play(scene, proxy.address, async (frame) => {
      if (frame !== 0 && frame !== 6) return;
      await daemon.stop();
      daemon = await OwnDaemon.start(HASTY);
      proxy.leadTo(daemon.address);
    });
    assert.deepEqual(killed.contacts, undisturbed.contacts);
    assert(killed.session.recreations >= 1, `${killed.session.recreations}`);
  });
}

/** The tip rises from its first pose, its first move; `disturb` is called while that frame is in flight. */
async function rise(transform: RigidMatrix | undefined, disturb: (sceneId: string) => unknown) {
  const client = await connect(proxy.address);
  const session = await client.session(TURNING, { restore: () => [] }); // nothing has moved
  const [floorUpdate, tipUpdate] = FIRST.updates!;
  await session.detect({ updates: [floorUpdate, { ...tipUpdate, transform }] });
  const answer = session.detect(frameAt(TURNING, 1));
  await disturb(session.scene.sceneId);
  const { vertexTriangle } = await answer;
  await session.close();
  await client.close();
  return { session, vertexTriangle };
}

for (const [name, transform] of Object.entries({
  "its first positions": undefined,
  "its first transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5],
})) {
  test(`a rigid mesh whose first move had no answer moves again from ${name}`, async () => {
    const undisturbed = await rise(transform, () => {});
    assert.equal(undisturbed.vertexTriangle.count, 1);
    const observer = await connect(daemon.address);
    const disturbed = await rise(transform, async (sceneId) => {
      proxy.mute();
      while ((await observer.getScene(sceneId)).lastFrameId < 2n);
      proxy.cut();
    });
    await observer.close();
    assert.deepEqual([disturbed.session.reconnects, disturbed.session.recreations], [1, 0]);
    assert.deepEqual(disturbed.vertexTriangle, undisturbed.vertexTriangle);
  });
}

test("a session goes on elsewhere if its endpoint is gone, and leaves a daemon that drains", async (t) => {
  const folder = mkdtempSync(join(tmpdir(), "members-"));
  const member = (name: string, graceSeconds: number) => {
    const address = `unix:${folder}/${name}`; // streams go there, and calls by the proxy
    return OwnDaemon.start(["--grace-seconds", `${graceSeconds}`, "--address", address, "--endpoint", address]);
  };
  const members = [await member("a", 0), await member("b", 600), await member("c", 0)];
  const way = new Proxy();
  await way.open(members[0].address);
  t.after(async () => {
    way.close();
    await Promise.all(members.map((each) => each.stop()));
    rmSync(folder, { recursive: true });
  });
  const client = await connect(way.address);
  let at = 0;
  const inTurn = (frame: number) => (frame < 1 ? frame : 2 - (frame % 2)); // however many frames a drain takes
  const session = await client.session(FALLING, { restore: () => [updateAt(FALLING, inTurn(at - 1))], giveUpSeconds: 30 });
  const goOn = async () => {
    const { vertexTriangle } = await session.detect(frameAt(FALLING, inTurn(at)));
    assert.equal(vertexTriangle.count, at === 0 ? 0 : 1);
    at += 1; // restore() may have been called before
  };
  for (let i = 0; i < 3; ++i) await goOn();

  way.leadTo(members[1].address);
  await members[0].stop();
  for (let i = 0; i < 3; ++i) await goOn();
  assert.equal(session.recreations, 1); // of a stream that broke, or that was left in time
  const broken = session.reconnects;

  way.leadTo(members[2].address);
  const stopped = members[1].stop();
  while (session.recreations === 1) await goOn();
  await stopped;
  await goOn();
  assert.deepEqual([session.reconnects, session.recreations], [broken, 2]);
  await session.close();
  await client.close();
});

test("a stream that idled out is opened again", async () => {
  const impatient = await OwnDaemon.start(["--max-idle-seconds", "1"]);
  const client = await connect(impatient.address);
  const session = await client.session(FALLING, { restore: () => [updateAt(FALLING, 0)], leaseSeconds: 60 });
  await session.detect(frameAt(FALLING, 0));
  let probe: FrameStream | undefined;
  while (!probe) probe = await client.stream(session.scene).catch(() => undefined); // refused while the session's is open
  await probe.finish();
  assert.equal((await session.detect(frameAt(FALLING, 1))).vertexTriangle.count, 1);
  assert.deepEqual([session.reconnects, session.recreations], [1, 0]);
  await session.close();
  await client.close();
  await impatient.stop();
});

test("a session can be closed while there is no connection", async () => {
  const gone = await OwnDaemon.start(HASTY);
  const client = await connect(gone.address, { patienceSeconds: 1 });
  const session = await client.session(FALLING, { restore: () => [] });
  await gone.stop();
  const lost = session.detect(frameAt(FALLING, 0));
  const told = refused(() => lost, Code.FAILED_PRECONDITION, "", /the session is closed/);
  await pause(200); // it is trying to reconnect
  const begin = performance.now();
  await refused(() => session.close(), Code.UNAVAILABLE, "", /no daemon answers/); // the scene may be there
  assert(performance.now() - begin < 5000);
  await told;
  await client.close();
});

test("a session tells what it cannot do", async () => {
  const client = await connect(daemon.address);
  const options = { restore: () => [updateAt(FALLING, 0)], giveUpSeconds: 0.2 };
  await refused(() => client.session(FALLING, {} as never), Code.INVALID_ARGUMENT, "options.restore");
  const session = await client.session(FALLING, options);
  await refused(() => session.detect({ edit: {} }), Code.INVALID_ARGUMENT, "frame.edit");
  await refused(() => session.detect({ fromLastFraction: 0 }), Code.INVALID_ARGUMENT, "frame.from_last_fraction");
  await refused(() => session.detect({ frameId: 1 }), Code.INVALID_ARGUMENT, "frame.frame_id");
  const first = session.detect(frameAt(FALLING, 0));
  await refused(() => session.detect(frameAt(FALLING, 1)), Code.FAILED_PRECONDITION, "", /before its last call was over/);
  await first;
  await refused(
    () => session.detect({ updates: [{ mesh: 1, positions: FLOOR.subarray(3) }] }),
    Code.INVALID_ARGUMENT,
    "frame.updates[0].positions",
  );
  assert.equal(session.reconnects, 0);
  const closing = await client.session(FALLING, options);
  const withdrawn = closing.detect(frameAt(FALLING, 0));
  await Promise.all([closing.close(), withdrawn.catch(() => {})]);
  await refused(() => closing.detect(frameAt(FALLING, 0)), Code.FAILED_PRECONDITION, "", /closed/);
  await closing.close();
  assert.deepEqual(
    (await client.listScenes()).map(({ sceneId }) => sceneId),
    [session.scene.sceneId],
  );
  await daemon.stop();
  await refused(() => session.detect(frameAt(FALLING, 1)), Code.UNAVAILABLE, "", /no daemon answers at unix:/);
  daemon = await OwnDaemon.start(HASTY);
  await client.close();
});
