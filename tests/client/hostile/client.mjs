// This program runs the Node client against a daemon that misbehaves. It reads lines "BEHAVIOUR SCENARIO ADDRESS" and runs
// all of them at once. For each it prints the code of the error, or ok, then the seconds that it took and the message.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import { pathToFileURL } from "node:url";

const [, , folder, limit] = process.argv;
const SECONDS = Number(limit);
const PACKAGE = pathToFileURL(join(folder, "dist", "src", "index.js")).href;
const { AdvanceMode, Code, CollidedError, ContactField, DetectionMode, connect, fractionsOf, moveAlong } = await import(PACKAGE);

const ONE = Uint32Array.of(0, 1, 2);
const INPUT = {
  mode: DetectionMode.CCD,
  meshes: [
    { name: "floor", vertexCount: 3, triangles: ONE },
    { name: "tip", vertexCount: 3, triangles: ONE },
  ],
};
const FRAME = {
  updates: [
    { mesh: 0, positions: Float32Array.of(0, 0, 0, 4, 0, 0, 0, 4, 0) },
    { mesh: 1, positions: Float32Array.of(1, 1, 1, 1.25, 1, 9, 1, 1.25, 9) },
  ],
};

/** A frame has no timeout of the client's: its caller's time is over. */
function within(promise, seconds) {
  const late = new CollidedError(Code.DEADLINE_EXCEEDED, "no output came in time");
  return Promise.race([promise, pause(1000 * seconds, undefined, { ref: false }).then(() => Promise.reject(late))]);
}

const SCENARIOS = {
  async stream(client) {
    const stream = await client.stream(await client.createScene(INPUT), { window: 2 });
    try {
      await stream.send(FRAME);
      await stream.send(FRAME);
      for (let frame = 0; frame < 2; ++frame) (await within(stream.receive(), SECONDS)).check();
      await stream.finish();
    } finally {
      stream.cancel();
    }
  },
  async advance(client) {
    const stream = await client.stream(await client.createScene(INPUT));
    try {
      await stream.detect(FRAME);
      const x = FRAME.updates[1].positions.slice();
      const target = x.map((c, i) => (i % 3 === 2 ? c - 2 : c));
      const frame = { updates: [{ mesh: 1, positions: target }], advance: true, advanceMode: AdvanceMode.PER_VERTEX };
      const { done, shortened } = await stream.detect(frame);
      moveAlong(x, target, fractionsOf(shortened, 3, 3));
      const has = JSON.stringify([done.advanced, done.way, [...shortened.ids], [...shortened.fractions], x[2], x[5], x[8]]);
      if (has !== "[0.25,0.75,[3,4],[0.25,0.5],0.5,8,7]") throw new Error(has);
      await stream.finish();
    } finally {
      stream.cancel();
    }
  },
  async limits(client) {
    const stream = await client.stream(await client.createScene(INPUT));
    try {
      await stream.detect(FRAME);
      const { limits } = await stream.detect({ ...FRAME, advance: true, limits: true });
      const has = JSON.stringify([limits.vertexTriangle, limits.edgeEdge].map(({ elements, toi }) => [...elements, ...toi]));
      if (has !== "[[3,0,0.5],[0,3,0.75]]") throw new Error(has);
      await stream.finish();
    } finally {
      stream.cancel();
    }
  },
  async pairs(client) {
    const input = { ...INPUT, mode: DetectionMode.DCD, fields: [ContactField.PAIR_STATES] };
    const stream = await client.stream(await client.createScene(input));
    try {
      const { pairs, vertexSolid, vertexTriangle } = await stream.detect(FRAME);
      const has = JSON.stringify([pairs.map(Object.values), [...vertexSolid.distance], [...vertexTriangle.signedDistances]]);
      if (has !== "[[[0,1,2,0,1,3,0.25]],[-0.25],[-0.25]]") throw new Error(has);
      await stream.finish();
    } finally {
      stream.cancel();
    }
  },
  async session(client) {
    const session = await client.session(INPUT, { restore: () => FRAME.updates, giveUpSeconds: SECONDS });
    try {
      await within(session.detect(FRAME), 2 * SECONDS);
    } finally {
      await session.close();
    }
  },
  async call(client) {
    (await client.detect(await client.createScene(INPUT), { ...FRAME, frameId: 1n })).check();
  },
  async watch(client) {
    const watcher = await client.watch(await client.createScene(INPUT), { positionMeshes: [1] });
    await within(watcher.receive(), SECONDS).finally(() => watcher.cancel());
  },
  mesh: async (client) => client.getMesh(await client.createScene(INPUT), 0),
  list: (client) => client.listScenes(),
};

async function play(line) {
  const [behaviour, scenario, address] = line.split(" ");
  const begun = performance.now();
  let code = "ok";
  let message = "";
  try {
    const client = await connect(address, { token: behaviour, patienceSeconds: SECONDS, deadlineSeconds: SECONDS });
    await SCENARIOS[scenario](client).finally(() => client.close());
  } catch (error) {
    code = error instanceof CollidedError ? Code[error.code] : "UNTYPED";
    message = String(error instanceof CollidedError ? error.message : error.stack).slice(0, 200).replaceAll("\n", " ");
  }
  console.log(behaviour, scenario, code, ((performance.now() - begun) / 1000).toFixed(3), message);
}

await Promise.all(readFileSync(0, "utf8").trim().split("\n").map(play));
process.exit(0); // whatever the daemon has not ended yet
