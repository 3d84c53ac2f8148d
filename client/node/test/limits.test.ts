import assert from "node:assert/strict";
import { test } from "node:test";
import { Code, ContactKind, PositionFormat } from "../src/index.js";
import { bytesOf } from "../src/arrays.js";
import { checkAsked, checkIds } from "../src/check_answer.js";
import { frameMessage } from "../src/frame.js";
import { ContactChunk } from "../src/generated/collided/v1/contact.js";
import { FrameDone } from "../src/generated/collided/v1/frame.js";
import { FrameOutput } from "../src/output.js";
import { refused } from "./support.js";

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
