// One triangle falls through another. `node first_contact.js [ADDRESS]`: without one it starts a daemon of its own.

import { DetectionMode, connect } from "collided";

const client = await connect(process.argv[2]);
const triangles = [0, 1, 2];
const scene = await client.createScene({
  mode: DetectionMode.CCD,
  meshes: ["floor", "falling"].map((name) => ({ name, vertexCount: 3, triangles })),
});
const floor = new Float32Array([0, 0, 0, 4, 0, 0, 0, 4, 0]);
const above = new Float32Array([1, 1, 1, 1.25, 1, 9, 1, 1.25, 9]);
const below = above.map((x, i) => (i % 3 === 2 ? x - 2 : x));
const updates = [
  { mesh: 0, positions: floor },
  { mesh: 1, startPositions: above, positions: below }, // t = 0 and t = 1
];
const { vertexTriangle } = await client.detect(scene, { frameId: 1, updates });
vertexTriangle.toi.forEach((t, i) => {
  const [vertex, triangle] = vertexTriangle.elements.subarray(2 * i);
  console.log(`vertex ${vertex}, triangle ${triangle}, t = ${t.toFixed(9)}`); // vertex 3, triangle 0, t = 0.500000000
});
await client.deleteScene(scene);
await client.close();
