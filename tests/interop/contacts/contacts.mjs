// The scene of contacts_test.py with the package for Node. usage: contacts.mjs ADDRESS, next to the package.

import { AdvanceMode, ContactField, DetectionMode, MeshMotion, PositionFormat, connect } from "collided";

const SIDE = 17;
const VERTICES = SIDE * SIDE;

/** A sheet of bumps; every coordinate is exact. */
function sheet(shift, height, a, b) {
  const vertex = (v) => [v % SIDE, Math.floor(v / SIDE)];
  const points = Array.from({ length: VERTICES }, (_, v) => vertex(v)).map(([i, j]) => [
    0.25 * i + shift,
    0.25 * j + shift,
    height + ((a * i + b * j) % 32) / 64,
  ]);
  return Float64Array.from(points.flat());
}

function triangles() {
  const corners = Array.from({ length: VERTICES }, (_, v) => v).filter((v) => v % SIDE < SIDE - 1 && v < VERTICES - SIDE);
  return corners.flatMap((v) => [v, v + 1, v + SIDE, v + 1, v + SIDE + 1, v + SIDE]);
}

function updatesOf(frame) {
  const upper = sheet(0.125, 2 - frame, 11, 5);
  if (frame < 4) return [...(frame === 0 ? [{ mesh: 0, positions: sheet(0, 0, 7, 13) }] : []), { mesh: 1, positions: upper }];
  // Every third vertex alone, back through the lower sheet.
  const indices = Array.from({ length: Math.ceil(VERTICES / 3) }, (_, n) => 3 * n);
  const positions = Float64Array.from(indices.flatMap((v) => [upper[3 * v], upper[3 * v + 1], upper[3 * v + 2] + 3]));
  return [{ mesh: 1, indices, positions }];
}

function bytesOf({ count, ...arrays }) {
  const { elements, stencils, toi, distance, weights, normals, flags, features } = arrays;
  const all = [Uint32Array.of(count), elements, stencils, toi, distance, weights, normals, flags, features];
  return Buffer.concat(all.map((array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength)));
}

function put({ vertexTriangle, edgeEdge }) {
  process.stdout.write(Buffer.concat([bytesOf(vertexTriangle), bytesOf(edgeEdge)]));
}

const client = await connect(process.argv[2]);
const meshes = Object.entries({ lower: MeshMotion.STATIC, upper: MeshMotion.DEFORMABLE });
const scene = await client.createScene({
  mode: DetectionMode.DCD_AND_CCD,
  thickness: 0.25,
  positionFormat: PositionFormat.F64,
  fields: Object.values(ContactField).filter((field) => field > 0 && field !== ContactField.PAIR_STATES), // those are of solids
  meshes: meshes.map(([name, motion]) => ({ name, vertexCount: VERTICES, triangles: triangles(), motion })),
});
const stream = await client.stream(scene);
for (let frame = 0; frame < 5; ++frame) {
  const updates = updatesOf(frame);
  if (frame === 2) {
    const options = { trial: true, advance: true, advanceMode: AdvanceMode.PER_VERTEX, limits: true };
    put((await stream.detect({ updates, ...options })).limits);
  }
  put(await stream.detect({ updates }));
  put(await stream.detect({ updates: [], mode: DetectionMode.DCD }));
}
await stream.finish();
await client.close();
