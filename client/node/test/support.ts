// A daemon for the tests of a file, and scenes with known contacts.

import assert from "node:assert/strict";
import { after, before } from "node:test";
import {
  type Client,
  Code,
  CollidedError,
  DetectionMode,
  type FrameInput,
  OwnDaemon,
  type SceneInput,
  connect,
} from "../src/index.js";

/** Starts a daemon before the file's tests, and stops it and the client after them. */
export function useDaemon(options: readonly string[] = []): { readonly client: Client; readonly address: string } {
  const used: { client: Client; address: string } = {} as never;
  let daemon: OwnDaemon | undefined;
  before(async () => {
    daemon = await OwnDaemon.start(["--threads", "2", ...options]);
    used.address = daemon.address;
    used.client = await connect(daemon.address);
  });
  after(async () => {
    await used.client?.close();
    await daemon?.stop();
  });
  return used;
}

export const FLOOR = new Float32Array([0, 0, 0, 4, 0, 0, 0, 4, 0]);
const TIP = new Float32Array([1, 1, 0, 1.25, 1, 8, 1, 1.25, 8]);

/** A triangle that stands on its corner, scene-wide vertex 3, which is at height z. */
export function tipAt(z: number): Float32Array {
  return TIP.map((x, i) => (i % 3 === 2 ? x + z : x));
}

export const TWO_TRIANGLES: SceneInput = {
  mode: DetectionMode.CCD,
  meshes: ["floor", "tip"].map((name) => ({ name, vertexCount: 3, triangles: [0, 1, 2] })),
};

/** The tip falls from 1 to 1 - depth, and meets the floor at t = 1 / depth. */
export function fall(depth: number, more: Partial<FrameInput> = {}): FrameInput {
  const updates = [
    { mesh: 0, positions: FLOOR },
    { mesh: 1, startPositions: tipAt(1), positions: tipAt(1 - depth) },
  ];
  return { updates, ...more };
}

/** Two sheets of n * n cells, one just above the other: many contacts. */
export function sheets(n: number): { scene: SceneInput; positions: Float32Array[] } {
  const side = n + 1;
  const triangles = Uint32Array.from(
    Array.from({ length: n * n }, (_, cell) => {
      const a = Math.floor(cell / n) * side + (cell % n);
      return [a, a + 1, a + side, a + 1, a + side + 1, a + side];
    }).flat(),
  );
  const sheet = (x: number, z: number) =>
    Float32Array.from(Array.from({ length: side * side }, (_, i) => [(i % side) + x, Math.floor(i / side) + x, z]).flat());
  const meshes = ["lower", "upper"].map((name) => ({ name, vertexCount: side * side, triangles, noSelfContacts: true }));
  return { scene: { mode: DetectionMode.DCD, thickness: 0.5, meshes }, positions: [sheet(0, 0), sheet(0.25, 0.1)] };
}

/** Expects a CollidedError with this code and field. */
export async function refused(call: () => unknown, code: Code, field: string, message = /./): Promise<CollidedError> {
  try {
    await call();
  } catch (error) {
    assert(error instanceof CollidedError, String(error));
    assert.deepEqual([Code[error.code], error.field], [Code[code], field], error.message);
    assert.match(error.message, message);
    return error;
  }
  return assert.fail("nothing was refused");
}
