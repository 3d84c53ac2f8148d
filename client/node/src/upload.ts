// The triangles of a new scene's meshes: those of small ones are in the message that creates it, others come in chunks, so that
// there may be any number.

import type { Connection } from "./connection.js";
import { Code, CollidedError } from "./errors.js";
import type { UploadMeshResponse } from "./generated/collided/v1/collision_service.js";
import { type Scene, SceneSpec } from "./generated/collided/v1/scene.js";

const CHUNK_BYTES = 12 * Math.floor((1 << 20) / 12); // whole triangles, well below the limit of any daemon
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

/** Uploads all triangles of mesh `mesh`; resolves with the scene after it. */
export async function uploadMesh(connection: Connection, sceneId: string, mesh: number, triangles: Uint8Array): Promise<Scene> {
  const limit = connection.deadlineSeconds + Math.ceil(triangles.length / CHUNK_BYTES);
  let settle: { resolve(answer: UploadMeshResponse): void; reject(error: CollidedError): void };
  const answered = new Promise<UploadMeshResponse>((resolve, reject) => (settle = { resolve, reject }));
  let isOver = false;
  const call = connection.upload("uploadMesh", sceneId, limit, (error, answer) => {
    isOver = true;
    call.emit("drain"); // nothing more is written
    if (error || !answer) settle.reject(error ?? new CollidedError(Code.INTERNAL, "an upload has no answer"));
    else settle.resolve(answer);
  });
  for (let at = 0; at < triangles.length && !isOver; at += CHUNK_BYTES) {
    const room = call.write({ sceneId, mesh, triangles: triangles.subarray(at, at + CHUNK_BYTES) });
    if (!room) await new Promise<void>((resolve) => call.once("drain", resolve));
  }
  call.end();
  return (await answered).scene!;
}
