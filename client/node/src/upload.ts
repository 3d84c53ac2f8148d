// The triangles of a new scene's meshes, in chunks, so that there may be any number.

import type { Connection } from "./connection.js";
import { Code, CollidedError } from "./errors.js";
import type { UploadMeshResponse } from "./generated/collided/v1/collision_service.js";
import type { Scene } from "./generated/collided/v1/scene.js";

const CHUNK_BYTES = 12 * Math.floor((1 << 20) / 12); // whole triangles, well below the limit of any daemon

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
