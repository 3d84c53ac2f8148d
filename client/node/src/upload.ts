// The triangles of a new scene's meshes: those of small ones are in the message that creates it, others come in chunks, so that
// there may be any number.

import type { Connection } from "./connection.js";
import { Code, CollidedError } from "./errors.js";
import type { UploadMeshResponse } from "./generated/collided/v1/collision_service.js";
import { type Scene, SceneSpec, SceneState } from "./generated/collided/v1/scene.js";

const CHUNK_BYTES = 12 * Math.floor((1 << 19) / 12); // whole triangles, well below the limit of any daemon
const UPLOADS_AT_ONCE = 8;
const MAX_INLINE_BYTES = 4 << 20; // of triangles in the message that creates a scene

/**
 * Leaves triangles in the spec, those of the smallest meshes first. Takes out those of the others, by mesh, which need a call
 * each: proto/README.md has the rule.
 */
export function takeLarge(spec: SceneSpec, maxMessageBytes: bigint): Map<number, Uint8Array> {
  const triangles = spec.meshes.map((mesh) => mesh.triangles);
  for (const mesh of spec.meshes) mesh.triangles = new Uint8Array();
  let left = Math.min(MAX_INLINE_BYTES, Number(maxMessageBytes / 2n) - SceneSpec.encode(spec).finish().length);
  const uploads = new Map<number, Uint8Array>();
  for (const [mesh, bytes] of [...triangles.entries()].sort(([, a], [, b]) => a.length - b.length)) {
    if (bytes.length <= left) {
      spec.meshes[mesh].triangles = bytes;
      left -= bytes.length;
    } else if (bytes.length > 0) {
      uploads.set(mesh, bytes);
    }
  }
  return uploads;
}

/** Uploads several meshes at a time, as each takes a round trip; resolves with the scene once it has all meshes. */
export async function uploadAll(connection: Connection, sceneId: string, uploads: Map<number, Uint8Array>): Promise<Scene> {
  const left = [...uploads.keys()];
  let ready: Scene | undefined;
  let failure: unknown;
  const crowded: number[] = []; // a client may have few calls open, or little memory: these go again, one by one
  const run = async (retried?: number[]) => {
    for (let mesh = left.shift(); mesh !== undefined && failure === undefined; mesh = left.shift()) {
      try {
        const scene = await uploadMesh(connection, sceneId, mesh, uploads.get(mesh)!);
        if (scene.state === SceneState.READY) ready = scene;
      } catch (error) {
        if (retried && error instanceof CollidedError && error.code === Code.RESOURCE_EXHAUSTED) retried.push(mesh);
        else failure ??= error;
      }
    }
  };
  await Promise.all(Array.from({ length: UPLOADS_AT_ONCE }, () => run(crowded)));
  left.push(...crowded);
  await run();
  if (failure !== undefined) throw failure;
  return ready!;
}

/** Uploads all triangles of mesh `mesh`; resolves with the scene after it. */
async function uploadMesh(connection: Connection, sceneId: string, mesh: number, triangles: Uint8Array): Promise<Scene> {
  const limit = connection.deadlineSeconds + Math.ceil(triangles.length / CHUNK_BYTES);
  let settle: { resolve(answer: UploadMeshResponse): void; reject(error: CollidedError): void };
  const answered = new Promise<UploadMeshResponse>((resolve, reject) => (settle = { resolve, reject }));
  let isOver = false;
  const chunks = chunksOf(connection, sceneId, mesh, triangles);
  let chunk = chunks.next(); // before the call begins: if the daemon is too old, this throws
  const call = connection.upload("uploadMesh", sceneId, limit, (error, answer) => {
    isOver = true;
    call.emit("drain"); // nothing more is written
    if (error || !answer) settle.reject(error ?? new CollidedError(Code.INTERNAL, "an upload has no answer"));
    else settle.resolve(answer);
  });
  for (; !chunk.done && !isOver; chunk = chunks.next()) {
    const takesMore = call.write(chunk.value);
    if (!takesMore) await new Promise<void>((resolve) => call.once("drain", resolve));
  }
  call.end();
  return (await answered).scene!;
}

function* chunksOf(connection: Connection, sceneId: string, mesh: number, triangles: Uint8Array): Generator<Buffer, void> {
  for (let at = 0; at < triangles.length; at += CHUNK_BYTES) {
    yield connection.encode("uploadMesh", { sceneId, mesh, triangles: triangles.subarray(at, at + CHUNK_BYTES) });
  }
}
