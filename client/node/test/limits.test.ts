import assert from "node:assert/strict";
import { test } from "node:test";
import { AdvanceMode, Code, ContactField, ContactKind, type FrameInput, PositionFormat, moveAlong } from "../src/index.js";
import { bytesOf } from "../src/arrays.js";
import { checkAsked, checkIds } from "../src/check_answer.js";
import { frameMessage } from "../src/frame.js";
import { ContactChunk } from "../src/generated/collided/v1/contact.js";
import { FrameDone } from "../src/generated/collided/v1/frame.js";
import { FrameOutput } from "../src/output.js";
import { FLOOR, TWO_TRIANGLES, refused, tipAt, useDaemon } from "./support.js";

const used = useDaemon();

const size = { meshes: 2, vertices: 6, elements: 2 };

/** Contacts that limit a way, whose first features are `ids`. */
function chunk(ids: number[], changes: Partial<ContactChunk> = {}): ContactChunk {
  const each = (...entry: number[]) => ids.flatMap(() => entry);
  return ContactChunk.create({
    kind: ContactKind.VERTEX_TRIANGLE,
    count: ids.length,
    elements: bytesOf(Uint32Array.from(ids.flatMap((id) => [id, 0]))),
    stencils: bytesOf(Uint32Array.from(each(3, 0, 1, 2))),
    toi: bytesOf(Float64Array.from(each(0.5))),
    distance: bytesOf(Float64Array.from(each(0.25))),
    weights: bytesOf(Float64Array.from(each(0.25, 0.5))),
    normals: bytesOf(Float32Array.from(each(0, 0, 1))),
    flags: bytesOf(Uint8Array.from(each(1))),
    ...changes,
  });
}

const outputOf = (messages: ContactChunk[], last: ContactChunk[]) =>
  new FrameOutput(1n, [], { done: FrameDone.create({ advanced: 0.5, limits: last }) }, [], messages);

test("a frame says that it wants to know what limits it", async () => {
  assert.equal(frameMessage({ advance: true, limits: true }, 1n, PositionFormat.F32).limits, true);
  assert.equal(frameMessage({ advance: true }, 1n, PositionFormat.F32).limits, false);
  const bad = () => frameMessage({ advance: true, limits: 1 as never }, 1n, PositionFormat.F32);
  await refused(bad, Code.INVALID_ARGUMENT, "frame.limits", /is 1/);
});

test("limits are joined from all messages", () => {
  const edges = chunk([1], { kind: ContactKind.EDGE_EDGE });
  const { limits, done, vertexTriangle } = outputOf([chunk([3]), chunk([4, 5])], [edges]);
  assert.deepEqual([limits.vertexTriangle.count, limits.edgeEdge.count, limits.triangleTriangle.count], [3, 1, 0]);
  assert.deepEqual([...limits.vertexTriangle.elements, ...limits.edgeEdge.elements], [3, 0, 4, 0, 5, 0, 1, 0]);
  assert.deepEqual(limits.vertexTriangle.weights, Float64Array.of(0.25, 0.5, 0.25, 0.5, 0.25, 0.5));
  assert.deepEqual([...limits.edgeEdge][0].normal, [0, 0, 1]);
  assert.deepEqual([done.limits, vertexTriangle.count], [[], 0]);
  checkAsked(limits, true);
  checkIds({ ...outputOf([], []), limits }, size);
  checkAsked(outputOf([], []).limits, false);
});

test("limits that cannot be are refused by name", async () => {
  const lost = (why: RegExp, call: () => unknown) => refused(call, Code.DATA_LOSS, "", why);
  for (const field of ["elements", "stencils", "toi", "distance", "weights", "normals", "flags"] as const) {
    const none = new Uint8Array();
    await lost(new RegExp(`limits.${field} has 0 entries for 1 contacts`), () => outputOf([], [chunk([3], { [field]: none })]));
    await lost(new RegExp(`limits.${field} has `), () => outputOf([chunk([3])], [chunk([4], { [field]: none })]));
    await lost(new RegExp(`limits.${field} has 99 bytes`), () => outputOf([chunk([3], { [field]: new Uint8Array(99) })], []));
  }
  for (const kind of [ContactKind.TRIANGLE_TRIANGLE, ContactKind.EDGE_TRIANGLE]) {
    await lost(new RegExp(`limits.kind is ${ContactKind[kind]}`), () => outputOf([chunk([0], { kind })], []));
  }
  const crossing = (pair: number[]) => ContactChunk.create({ kind: ContactKind.EDGE_TRIANGLE, count: 1, elements: bytesOf(Uint32Array.from(pair)) });
  const named = (pair: number[]) => checkIds(new FrameOutput(1n, [crossing(pair)], {}), size);
  named([3 * size.elements - 1, size.elements - 1]);
  await lost(/contacts.elements names/, () => named([3 * size.elements, 0]));
  await lost(/contacts.elements names/, () => named([0, size.elements]));
  await lost(/limits.kind is 77/, () => outputOf([], [chunk([3], { kind: 77 as never })]));
  await lost(/limits.count is 0/, () => outputOf([], [chunk([], {})]));
  await lost(/limits.toi has 1.5/, () => outputOf([], [chunk([3], { toi: bytesOf(Float64Array.of(1.5)) })]));
  await lost(/limits.distance has NaN/, () => outputOf([], [chunk([3], { distance: bytesOf(Float64Array.of(NaN)) })]));
  await lost(/limits.elements names 6/, () => checkIds(outputOf([], [chunk([6])]), size));
  const stencils = bytesOf(Uint32Array.of(3, 0, 1, 6));
  await lost(/limits.stencils names 6/, () => checkIds(outputOf([], [chunk([3], { stencils })]), size));
  await lost(/limits has 2 contacts, and the frame did not ask/, () => checkAsked(outputOf([chunk([3])], [chunk([4])]).limits, false));
});

const GAP = 0.25; // that the tip keeps above the floor
const SCENE = { ...TWO_TRIANGLES, minSeparation: GAP, fields: [ContactField.TOI] };

function limited(depth: number, more: Partial<FrameInput> = {}): FrameInput {
  const updates = [{ mesh: 1, positions: tipAt(1 - depth) }];
  return { updates, advance: true, advanceMode: AdvanceMode.PER_VERTEX, limits: true, ...more };
}

const first = [
  { mesh: 0, positions: FLOOR },
  { mesh: 1, positions: tipAt(1) },
];

/** Expects the tip's way down from 1 by 2 to be limited by the floor. */
function checkLimited({ limits, vertexTriangle, done }: FrameOutput): void {
  const { count, elements, stencils, toi, distance, weights, normals, flags } = limits.vertexTriangle;
  assert.deepEqual([count, limits.edgeEdge.count, limits.triangleTriangle.count], [1, 0, 0]);
  assert.deepEqual([...elements, ...stencils, ...distance, ...normals, flags.length], [3, 0, 3, 0, 1, 2, GAP, 0, 0, 1, 1]);
  const x = Float64Array.from(tipAt(1));
  moveAlong(x, Float64Array.from(tipAt(-1)), toi[0]);
  assert(x[2] >= GAP && x[2] < GAP + 1e-3, `${x[2]} is where the tip comes to the distance`);
  assert(weights.every((weight) => Math.abs(weight - 0.25) < 1e-6));
  assert.deepEqual([done.contactCount, done.limits, vertexTriangle.elements.length], [1n, [], 0]);
}

test("limits tell when a pair comes to what it keeps", async () => {
  const scene = await used.client.createScene(SCENE);
  await used.client.detect(scene, { frameId: 1, updates: first });
  const unary = await used.client.detect(scene, limited(2, { frameId: 2, trial: true }));
  checkLimited(unary);
  const stream = await used.client.stream(scene);
  const streamed = await stream.detect(limited(2));
  checkLimited(streamed);
  assert.deepEqual(streamed.limits, unary.limits);
  await stream.finish();
});

test("there are no limits where nothing blocks and where nobody asks", async () => {
  const stream = await used.client.stream(await used.client.createScene(SCENE));
  await stream.detect({ updates: first });
  for (const frame of [limited(0.5), limited(2, { limits: false, trial: true })]) {
    const { vertexTriangle, edgeEdge } = (await stream.detect(frame)).limits;
    assert.deepEqual([vertexTriangle.count, edgeEdge.count], [0, 0]);
  }
  const plain = limited(2, { advance: false, advanceMode: undefined });
  await refused(() => stream.detect(plain), Code.INVALID_ARGUMENT, "frame.limits", /advance/);
  await stream.finish();
});
