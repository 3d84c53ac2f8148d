import assert from "node:assert/strict";
import { test } from "node:test";
import { Accuracy, Code, ContactField, ContactKind, DetectionMode, MeshPairState, PositionFormat, type SceneInput, contactPoints } from "../src/index.js";
import { bytesOf } from "../src/arrays.js";
import { checkIds } from "../src/check_answer.js";
import { ContactChunk, MeshPairs } from "../src/generated/collided/v1/contact.js";
import { FrameDone } from "../src/generated/collided/v1/frame.js";
import { FrameOutput } from "../src/output.js";
import { refused, useDaemon } from "./support.js";

const used = useDaemon();
const lost = (why: RegExp, call: () => unknown) => refused(call, Code.DATA_LOSS, "", why);

const NONE = 2 ** 32 - 1;

/** Pairs as a message has them: two meshes, the state, vertices inside of both, the deepest and its depth. */
function message(...rows: [number, number, number, number, number, number, number][]): MeshPairs {
  const column = (...places: number[]) => rows.flatMap((row) => places.map((place) => row[place]));
  return MeshPairs.create({
    meshes: bytesOf(Uint32Array.from(column(0, 1))),
    states: Uint8Array.from(column(2)),
    inside: bytesOf(Uint32Array.from(column(3, 4))),
    deepest: bytesOf(Uint32Array.from(column(5))),
    depths: bytesOf(Float64Array.from(column(6))),
  });
}

const outputOf = (messages: MeshPairs[], last?: MeshPairs) =>
  new FrameOutput(1n, [], { done: FrameDone.create({ pairs: last }) }, [], [], messages);

test("pairs are joined from all messages", () => {
  const { TOUCHING, OVERLAPPING, SECOND_INSIDE } = MeshPairState;
  const { pairs, done } = outputOf([message([0, 1, OVERLAPPING, 2, 0, 3, 0.5], [0, 2, TOUCHING, 0, 0, NONE, 0])], message([1, 2, SECOND_INSIDE, 0, 8, 17, 1.5]));
  assert.deepEqual(pairs, [
    { first: 0, second: 1, state: OVERLAPPING, firstInside: 2, secondInside: 0, deepest: 3, depth: 0.5 },
    { first: 0, second: 2, state: TOUCHING, firstInside: 0, secondInside: 0, deepest: undefined, depth: 0 },
    { first: 1, second: 2, state: SECOND_INSIDE, firstInside: 0, secondInside: 8, deepest: 17, depth: 1.5 },
  ]);
  assert.equal(done.pairs, undefined);
  checkIds(outputOf([message([1, 2, 2, 0, 8, 17, 1.5])]), { meshes: 3, vertices: 18, elements: 1 });
  assert.deepEqual(outputOf([]).pairs, []);
});

test("pairs that cannot be are refused by name", async () => {
  const of = (...row: Parameters<typeof message>) => () => outputOf([message(...row)]);
  await lost(/pairs.meshes has 1 and 1/, of([1, 1, 1, 0, 0, NONE, 0]));
  await lost(/pairs.meshes has 0 and 1; pairs must ascend/, of([0, 1, 1, 0, 0, NONE, 0], [0, 1, 1, 0, 0, NONE, 0]));
  await lost(/pairs.states has 0/, of([0, 1, 0, 0, 0, NONE, 0]));
  await lost(/pairs.states has 5/, of([0, 1, 5, 0, 0, NONE, 0]));
  await lost(/pairs.deepest has no vertex/, of([0, 1, 2, 0, 1, NONE, 0]));
  await lost(/pairs.deepest has 3/, of([0, 1, 2, 0, 0, 3, 0]));
  for (const depth of [-1, NaN, Infinity]) await lost(/pairs.depths has/, of([0, 1, 2, 1, 0, 3, depth]));
  for (const name of ["meshes", "inside", "deepest", "depths"] as const) {
    const cut = { ...message([0, 1, 1, 0, 0, NONE, 0]), [name]: new Uint8Array(3) };
    await lost(new RegExp(`pairs.${name} has 3 bytes for 1 pairs`), () => outputOf([cut]));
  }
  const size = { meshes: 2, vertices: 6, elements: 2 };
  await lost(/pairs.meshes names 2; the scene has 2 meshes/, () => checkIds(outputOf([message([0, 2, 1, 0, 0, NONE, 0])]), size));
  await lost(/pairs.deepest names 6; the scene has 6 vertices/, () => checkIds(outputOf([message([0, 1, 2, 0, 1, 6, 1])]), size));
});

test("distances that cannot be are refused by name", async () => {
  const of = (kind: ContactKind, distance: number, sign?: number) => () => {
    const signed = sign === undefined ? {} : { signedDistances: bytesOf(Float64Array.of(sign)) };
    return new FrameOutput(1n, [ContactChunk.create({ kind, count: 1, distance: bytesOf(Float64Array.of(distance)), ...signed })], {});
  };
  assert.equal(of(ContactKind.VERTEX_SOLID, -0.5)().vertexSolid.distance[0], -0.5);
  await lost(/contacts.distance has 0.5; it must be below 0/, of(ContactKind.VERTEX_SOLID, 0.5));
  for (const sign of [0.25, -0.25, NaN]) {
    assert.deepEqual([...of(ContactKind.EDGE_EDGE, 0.25, sign)().edgeEdge].map(({ signedDistance }) => signedDistance), [sign]);
  }
  await lost(/contacts.signed_distances has 0.5; it must be 0.25/, of(ContactKind.EDGE_EDGE, 0.25, 0.5));
  const long = ContactChunk.create({ kind: ContactKind.EDGE_EDGE, count: 1, signedDistances: new Uint8Array(9) });
  await lost(/contacts.signed_distances has 9 bytes for 1 contacts; it needs 8/, () => new FrameOutput(1n, [long], {}));
});

// Vertex i of a box is at (i & 1, i >> 1 & 1, i >> 2); the triangles' normals point outside.
const SIDES = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5];

/** A box with this side, whose lowest corner is at (x, y, z). */
function boxAt(x: number, y: number, z: number, side: number): Float64Array {
  return Float64Array.from({ length: 8 }, (_, i) => i).reduce((box, i) => {
    box.set([x + side * (i & 1), y + side * ((i >> 1) & 1), z + side * (i >> 2)], 3 * i);
    return box;
  }, new Float64Array(24));
}

const BOXES: SceneInput = {
  mode: DetectionMode.DCD,
  accuracy: Accuracy.EXACT,
  positionFormat: PositionFormat.F64,
  thickness: 0.75,
  kinds: [ContactKind.VERTEX_TRIANGLE, ContactKind.VERTEX_SOLID],
  fields: [
    ContactField.ELEMENTS,
    ContactField.STENCIL,
    ContactField.DISTANCE,
    ContactField.WEIGHTS,
    ContactField.NORMAL,
    ContactField.PAIR_STATES,
    ContactField.SIGNED_DISTANCE,
  ],
  meshes: ["room", "box"].map((name) => ({ name, vertexCount: 8, triangles: SIDES, solid: true, noSelfContacts: true })),
};
const ROOM = boxAt(0, 0, 0, 4);

test("meshes are apart, touch, overlap, or are inside each other", async () => {
  const { TOUCHING, OVERLAPPING, SECOND_INSIDE } = MeshPairState;
  const scene = await used.client.createScene(BOXES);
  const stream = await used.client.stream(scene);
  for (const [z, state, inside] of [[4.5, undefined, 0], [4, TOUCHING, 0], [3.5, OVERLAPPING, 4], [1.5, SECOND_INSIDE, 8]] as const) {
    const updates = [ROOM, boxAt(1.25, 1.5, z, 1)].map((positions, mesh) => ({ mesh, positions }));
    const { pairs, vertexSolid, done } = await stream.detect({ updates });
    const has = pairs.map((pair) => [pair.first, pair.second, pair.state, pair.firstInside, pair.secondInside, pair.deepest !== undefined]);
    assert.deepEqual(has, state === undefined ? [] : [[0, 1, state, 0, inside, inside > 0]]);
    assert.deepEqual([vertexSolid.count, done.metrics!.counts!.contactsVertexSolid], [inside, BigInt(inside)]);
    if (state === OVERLAPPING) assert.equal(pairs[0].depth, 0.5);
  }
  await stream.finish();
  await used.client.deleteScene(scene);
});

test("a vertex in a solid has a depth, and its distances a sign", async () => {
  const scene = await used.client.createScene(BOXES);
  const box = boxAt(1.25, 1.5, 2.5, 1); // its upper side is 0.5 below that of the room
  const updates = [ROOM, box].map((positions, mesh) => ({ mesh, positions }));
  const { vertexSolid, vertexTriangle } = await used.client.detect(scene, { frameId: 1, updates });
  assert.deepEqual([vertexSolid.count, vertexSolid.elements[8], vertexSolid.distance[4]], [8, 12, -0.5]);
  assert.deepEqual([...vertexSolid.normals.subarray(12, 15)], [0, 0, 1]);
  const { first, second } = contactPoints(ContactKind.VERTEX_SOLID, vertexSolid, Float64Array.of(...ROOM, ...box));
  assert.deepEqual([...first.subarray(12, 15)], [1.25, 1.5, 3.5]);
  assert(Math.abs(second[14] - 4) < 1e-12);
  assert(vertexTriangle.count > 0);
  assert.deepEqual(vertexTriangle.signedDistances, vertexTriangle.distance.map((distance) => -distance));
  await used.client.deleteScene(scene);
});

test("what is no solid is refused", async () => {
  const mesh = { name: "box", vertexCount: 8, triangles: SIDES };
  const open = { ...BOXES, meshes: [{ ...mesh, triangles: SIDES.slice(3), solid: true }] };
  await refused(() => used.client.createScene(open), Code.INVALID_ARGUMENT, "spec.meshes[0].solid", /edge/);
  await refused(() => used.client.createScene({ ...BOXES, kinds: [], meshes: [mesh] }), Code.INVALID_ARGUMENT, "spec.fields[5]", /PAIR_STATES/);
  const bad = { ...BOXES, meshes: [{ ...mesh, solid: 1 as never }] };
  await refused(() => used.client.createScene(bad), Code.INVALID_ARGUMENT, "spec.meshes[0].solid", /true or false/);
});
