import assert from "node:assert/strict";
import { test } from "node:test";
import {
  AdvanceMode,
  type Client,
  Code,
  ContactField,
  ContactKind,
  DetectionMode,
  MeshMotion,
  type MeshUpdateInput,
  PositionFormat,
  type RigidMatrix,
  type SceneInput,
  contactPoints,
  elementKind,
  fractionsOf,
  moveAlong,
  moveRigidly,
  packQuantized,
  poseAlong,
  unpackQuantized,
} from "../src/index.js";
import { FLOOR, TWO_TRIANGLES, fall, refused, tipAt, useDaemon } from "./support.js";

const used = useDaemon();

/** Where the daemon has the vertices of mesh 1 after each frame. */
async function whereTheDaemonHasThem(client: Client, spec: SceneInput, frames: MeshUpdateInput[][], options = {}) {
  const scene = await client.createScene(spec);
  const watcher = await client.watch(scene, { positionMeshes: [1] });
  const stream = await client.stream(scene);
  const seen = [];
  for (const [i, updates] of frames.entries()) {
    const { done, shortened } = await stream.detect({ updates, ...(i > 0 ? options : {}) });
    seen.push({ done, shortened, positions: (await watcher.receive()).positions[0].positions });
  }
  await stream.finish();
  await client.deleteScene(scene);
  return seen;
}

for (const Type of [Float32Array, Float64Array]) {
  test(`moveAlong goes where the daemon goes, to the last bit (${Type.name})`, async () => {
    const positionFormat = Type === Float32Array ? PositionFormat.F32 : PositionFormat.F64;
    const spec = { ...TWO_TRIANGLES, positionFormat, minSeparation: 1e-3 };
    const x = Type.from(tipAt(1.1));
    const steps = [0.3, 0.7, 1.9].map((drop, step) => x.map((c, i) => (i % 3 === 2 ? c - drop : c + 0.013 * (i + step))));
    const frames = [
      [
        { mesh: 0, positions: Type.from(FLOOR) },
        { mesh: 1, positions: x.slice() },
      ],
    ];
    frames.push(...steps.map((positions) => [{ mesh: 1, positions }]));
    const seen = await whereTheDaemonHasThem(used.client, spec, frames as MeshUpdateInput[][], { advance: true });
    for (const [i, target] of steps.entries()) {
      const { done, positions } = seen[i + 1];
      moveAlong<Float32Array | Float64Array>(x, target, done.advanced!);
      assert.deepEqual(x, positions);
    }
    const advanced = seen.at(-1)!.done.advanced!;
    assert(advanced > 0 && advanced < 1, `${advanced} tests no rounding`);
  });

  for (const advanceMode of [AdvanceMode.PER_MESH, AdvanceMode.PER_VERTEX]) {
    test(`moveAlong goes where the daemon goes, ${AdvanceMode[advanceMode]} (${Type.name})`, async () => {
      const positionFormat = Type === Float32Array ? PositionFormat.F32 : PositionFormat.F64;
      const spec = { ...TWO_TRIANGLES, positionFormat, minSeparation: 1e-3 };
      const x = Type.from(tipAt(1.1));
      const steps = [0.3, 0.7, 1.9].map((drop, step) => x.map((c, i) => (i % 3 === 2 ? c - drop : c + 0.013 * (i + step))));
      const first = [
        { mesh: 0, positions: Type.from(FLOOR) },
        { mesh: 1, positions: x.slice() },
      ];
      const frames = [first, ...steps.map((positions) => [{ mesh: 1, positions }])] as MeshUpdateInput[][];
      const seen = await whereTheDaemonHasThem(used.client, spec, frames, { advance: true, advanceMode });
      for (const [i, target] of steps.entries()) {
        const { shortened, positions } = seen[i + 1];
        const isMesh = advanceMode === AdvanceMode.PER_MESH;
        const fraction = isMesh ? fractionsOf(shortened, 1, 1)[0] : fractionsOf(shortened, 3, 3);
        moveAlong<Float32Array | Float64Array>(x, target, fraction);
        assert.deepEqual(x, positions);
      }
      const { done, shortened } = seen.at(-1)!;
      assert(shortened.ids.length > 0 && done.advanced! < 1 && done.way! >= done.advanced!, "tests no rounding");
    });
  }

  test(`moveAlong moves each vertex by a fraction of its own (${Type.name})`, () => {
    const fractions = Float64Array.of(1 / 3, 0, 1, 127 / 128, 1e-300, 0.7);
    const x = new Type(18).map((_, i) => [1.1 * i, -7e5, 1e-6][i % 3]);
    const p = new Type(18).map((_, i) => [0.3 - i, 2 / 3, 1e7][i % 3]);
    const expected = x.slice();
    fractions.forEach((fraction, i) => {
      const [from, to] = [expected, p].map((all) => all.subarray(3 * i, 3 * i + 3));
      moveAlong<Float32Array | Float64Array>(from, to, fraction);
    });
    moveAlong<Float32Array | Float64Array>(x, p, fractions);
    assert.deepEqual(x, expected);
    assert.deepEqual([x.subarray(3, 6), x.subarray(6, 9)], [Type.of(1.1 * 3, -7e5, 1e-6), p.subarray(6, 9)]);
  });

  test(`moveRigidly goes where the daemon goes, to the last bit (${Type.name})`, async () => {
    const positionFormat = Type === Float32Array ? PositionFormat.F32 : PositionFormat.F64;
    const [floor, tip] = TWO_TRIANGLES.meshes;
    const spec = { ...TWO_TRIANGLES, positionFormat, meshes: [floor, { ...tip, motion: MeshMotion.RIGID }] };
    const [c, s] = [Math.cos(0.7), Math.sin(0.7)];
    const transform = [c, -s, 0, 0.1, s, c, 0, -0.3, 0, 0, 1, 1 / 3];
    const first = Type.from(tipAt(1.1));
    const frames = [
      [
        { mesh: 0, positions: Type.from(FLOOR) },
        { mesh: 1, positions: first },
      ],
      [{ mesh: 1, transform }],
    ];
    const seen = await whereTheDaemonHasThem(used.client, spec, frames as MeshUpdateInput[][]);
    const moved = first.slice();
    moveRigidly(moved, transform);
    assert.deepEqual(moved, seen[1].positions);
    assert.equal(seen[1].done.metrics!.bytesIn, 96n);
  });
}

/** The pose that turns the tip about a line through (1, 1, 1), and moves it down. */
function bodyTurned(angle: number, depth: number): number[] {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [1, 0, 0, 0, 0, c, -s, 1 - c + s, 0, s, c, 1 - c - s - depth];
}
const AT_REST = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

for (const Type of [Float32Array, Float64Array]) {
  for (const advanceMode of [AdvanceMode.PER_MESH, AdvanceMode.PER_VERTEX]) {
    test(`poseAlong goes where the daemon goes, to the last bit, ${AdvanceMode[advanceMode]} (${Type.name})`, async () => {
      const positionFormat = Type === Float32Array ? PositionFormat.F32 : PositionFormat.F64;
      const [floor, tip] = TWO_TRIANGLES.meshes;
      const spec = { ...TWO_TRIANGLES, positionFormat, minSeparation: 1e-2, meshes: [floor, { ...tip, motion: MeshMotion.RIGID }] };
      const x = Type.from(tipAt(1.1));
      const targets = [bodyTurned(0.3, 0.2), bodyTurned(1.2, 2.5), bodyTurned(0.1, 3)];
      const first = [
        { mesh: 0, positions: Type.from(FLOOR) },
        { mesh: 1, positions: x },
      ];
      const frames = [first, ...targets.map((transform) => [{ mesh: 1, transform }])] as MeshUpdateInput[][];
      const seen = await whereTheDaemonHasThem(used.client, spec, frames, { advance: true, advanceMode });
      const isMesh = advanceMode === AdvanceMode.PER_MESH;
      const fractions = seen.map(({ shortened }) => Math.min(...fractionsOf(shortened, isMesh ? 1 : 3, isMesh ? 1 : 3)));
      let pose: RigidMatrix = AT_REST;
      for (const [i, target] of targets.entries()) {
        pose = poseAlong(pose, target, fractions[i + 1]);
        const moved = x.slice();
        moveRigidly(moved, pose);
        assert.deepEqual(moved, seen[i + 1].positions);
      }
      assert(fractions[2] > 0 && fractions[2] < 1, `${fractions[2]} tests no rounding`);
    });
  }
}

test("poseAlong of what does not turn is moveAlong of its translation", () => {
  const [start, target] = [bodyTurned(0.7, 1 / 3), bodyTurned(0.7, -9)];
  for (const fraction of [0, 1e-300, 1 / 3, 0.5, 127 / 128, 1]) {
    const [x, p] = [start, target].map((pose) => Float64Array.of(pose[3], pose[7], pose[11]));
    moveAlong(x, p, fraction);
    const expected = Float64Array.from(start, (entry, i) => (i % 4 === 3 ? x[(i - 3) / 4] : entry));
    assert.deepEqual(poseAlong(start, target, fraction), expected);
  }
});

test("Q16 is packed as the daemon reads it", async () => {
  const quantizationBox = { lower: [-1, -2, -3], upper: [5, 6.5, 9.1] };
  const spec = { ...TWO_TRIANGLES, positionFormat: PositionFormat.Q16, quantizationBox };
  const [floor, tip] = [FLOOR, tipAt(1 / 3)].map((positions) => packQuantized(positions, quantizationBox));
  const [{ positions }] = await whereTheDaemonHasThem(used.client, spec, [
    [
      { mesh: 0, positions: floor },
      { mesh: 1, positions: tip },
    ],
  ]);
  assert.deepEqual(unpackQuantized(tip, quantizationBox), positions);
  positions.forEach((x, i) => assert(Math.abs(x - tipAt(1 / 3)[i]) <= 12.1 / 65535));
  assert.deepEqual([...packQuantized([0, 0, 0], { lower: [0, 0, 0], upper: [0, 0, 0] })], [0, 0, 0]);
  assert.deepEqual([...packQuantized([1, 0.5, 0], { lower: [0, 0, 0], upper: [1, 1, 1] })], [65535, 32768, 0]);
});

test("helpers refuse what they cannot do", async () => {
  const box = { lower: [0, 0, 0], upper: [1, 1, 1] };
  const three = new Float32Array(3);
  await refused(() => packQuantized([0, 2, 0], box), Code.INVALID_ARGUMENT, "positions[1]", /is 2, outside the box, 0 to 1/);
  await refused(() => packQuantized([NaN, 0, 0], box), Code.INVALID_ARGUMENT, "positions[0]");
  await refused(() => packQuantized([0, 0], box), Code.INVALID_ARGUMENT, "positions", /multiple of 3/);
  await refused(() => packQuantized([], { ...box, upper: [1] }), Code.INVALID_ARGUMENT, "box.upper", /needs 3/);
  await refused(() => packQuantized([], { ...box, upper: [1, 1, -1] }), Code.INVALID_ARGUMENT, "box");
  await refused(() => moveAlong(three, new Float32Array(6), 0.5), Code.INVALID_ARGUMENT, "target");
  await refused(() => moveAlong(three, new Float64Array(3) as never, 0.5), Code.INVALID_ARGUMENT, "target");
  await refused(() => moveAlong(three, three, NaN), Code.INVALID_ARGUMENT, "fraction", /is NaN; it must be from 0 to 1/);
  const half = [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 5];
  await refused(() => poseAlong([1], half, 0.5), Code.INVALID_ARGUMENT, "start", /12 finite numbers/);
  await refused(() => poseAlong(half, [...half.slice(1), NaN], 0.5), Code.INVALID_ARGUMENT, "target", /12 finite numbers/);
  await refused(() => poseAlong(half, half, NaN), Code.INVALID_ARGUMENT, "fraction", /is NaN; it must be from 0 to 1/);
  await refused(() => poseAlong(half, half, -0.1), Code.INVALID_ARGUMENT, "fraction", /is -0.1/);
  await refused(() => poseAlong(half, half, Float64Array.of(0.5) as never), Code.INVALID_ARGUMENT, "fraction");
  await refused(() => poseAlong(AT_REST, half, 0.5), Code.INVALID_ARGUMENT, "target", /half a turn from that of start/);
  assert.deepEqual(poseAlong(AT_REST, half, 1), Float64Array.from(half));
  const [from, to] = [new Float32Array(6), new Float32Array(6).fill(1)];
  const each = (...fractions: number[]) => moveAlong(from, to, Float64Array.from(fractions));
  await refused(() => each(0.5), Code.INVALID_ARGUMENT, "fraction", /a Float64Array of 1; it must be a number, or a Float64Array of 2/);
  await refused(() => each(0.5, NaN), Code.INVALID_ARGUMENT, "fraction[1]", /is NaN; it must be from 0 to 1/);
  await refused(() => each(0.5, 1.5), Code.INVALID_ARGUMENT, "fraction[1]", /is 1.5/);
  await refused(() => moveAlong(from, to, [0, 0] as never), Code.INVALID_ARGUMENT, "fraction", /an array of 2/);
  await refused(() => moveAlong(from, to, undefined as never), Code.INVALID_ARGUMENT, "fraction", /is undefined/);
  assert.deepEqual(from, new Float32Array(6));
  await refused(() => moveAlong([1, 2, 3] as never, three, 0), Code.INVALID_ARGUMENT, "positions");
  await refused(() => moveRigidly(three, [1]), Code.INVALID_ARGUMENT, "matrix", /12 finite numbers/);
});

test("contact points lie where CONVENTIONS.md says", async () => {
  const scene = await used.client.createScene({
    ...TWO_TRIANGLES,
    fields: [ContactField.STENCIL, ContactField.TOI, ContactField.WEIGHTS],
  });
  const { vertexTriangle } = await used.client.detect(scene, fall(2, { frameId: 1 }));
  const [start, end] = [1, -1].map((z) => [...FLOOR, ...tipAt(z)]);
  const { first, second } = contactPoints(ContactKind.VERTEX_TRIANGLE, vertexTriangle, end, start);
  const near = (points: Float64Array) => [...points].map((x) => Math.round(x * 1e6) / 1e6 + 0);
  assert.deepEqual(
    [near(first), near(second)],
    [
      [1, 1, 0],
      [1, 1, 0],
    ],
  );
  assert.equal(elementKind(vertexTriangle, 0), "triangle");
  await refused(() => elementKind(vertexTriangle, 1), Code.INVALID_ARGUMENT, "i");
  await refused(
    () => contactPoints(ContactKind.VERTEX_TRIANGLE, vertexTriangle, end.slice(9), start.slice(9)),
    Code.INVALID_ARGUMENT,
    "end",
  );
  await refused(
    () => contactPoints(ContactKind.VERTEX_TRIANGLE, { ...vertexTriangle, weights: new Float64Array() }, end),
    Code.INVALID_ARGUMENT,
    "contacts.weights",
  );
});

test("hair and particles meet as edges and points", async () => {
  const meshes = [
    { name: "strand", vertexCount: 3, edges: [0, 1, 1, 2] },
    { name: "drops", vertexCount: 3, points: new Uint32Array([0, 1, 2]) },
  ];
  const scene = await used.client.createScene({ mode: DetectionMode.CCD, thickness: 0.02, meshes });
  const updates = [
    { mesh: 0, positions: new Float32Array([0, 0, 0, 1, 0, 0, 2, 0, 0]) },
    {
      mesh: 1,
      startPositions: new Float32Array([0.25, 0, 1, 5, 0, 0, 5.5, 0, 0]),
      positions: new Float32Array([0.25, 0, -1, 6, 0, 0, 4.5, 0, 0]),
    },
  ];
  const { vertexTriangle } = await used.client.detect(scene, { frameId: 1, updates });
  assert.deepEqual([...vertexTriangle.elements], [3, 0, 4, 4]);
  assert.deepEqual(
    [0, 1].map((i) => elementKind(vertexTriangle, i)),
    ["edge", "point"],
  );
});

test("sparse updates and edits change what they name", async () => {
  const scene = await used.client.createScene(TWO_TRIANGLES);
  const stream = await used.client.stream(scene);
  await stream.detect(fall(0.5));
  const down = await stream.detect({ updates: [{ mesh: 1, indices: [0], positions: new Float32Array([1, 1, -1]) }] });
  assert.deepEqual([...down.vertexTriangle.elements], [3, 0]);
  await refused(
    () => stream.detect({ updates: [{ mesh: 1, indices: [2, 0], positions: new Float32Array(6) }] }),
    Code.INVALID_ARGUMENT,
    "frame.updates[0].sparse.indices",
  );
  const removed = await stream.detect({ edit: { meshes: [{ mesh: 0 }] } });
  assert.equal(removed.done.contactCount, 0n);
  const floor = { ...TWO_TRIANGLES.meshes[0], motion: MeshMotion.STATIC };
  const up = { mesh: 1, indices: [0], positions: new Float32Array([1, 1, 1]) };
  const again = await stream.detect({
    edit: { meshes: [{ mesh: 0, spec: floor }] },
    updates: [{ mesh: 0, positions: FLOOR }, up],
  });
  assert.deepEqual([...again.vertexTriangle.elements], [3, 0]);
  const apart = await stream.detect({
    edit: { excludeMeshes: [[0, 1]] },
    updates: [{ ...up, positions: new Float32Array([1, 1, -1]) }],
  });
  assert.equal(apart.done.contactCount, 0n);
  assert.equal((await used.client.getScene(scene.sceneId)).editCount, 3n);
  await refused(() => stream.detect({ edit: { meshes: [{ mesh: 9 }] } }), Code.INVALID_ARGUMENT, "frame.edit.meshes[0].mesh");
  await refused(
    () => stream.detect({ edit: { meshes: [{ mesh: 0, spec: null as never }] } }),
    Code.INVALID_ARGUMENT,
    "frame.edit.meshes[0].spec",
  );
  await refused(() => stream.detect({ edit: { remove: [1] } as never }), Code.INVALID_ARGUMENT, "frame.edit.remove");
  await stream.finish();
});
