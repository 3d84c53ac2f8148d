import assert from "node:assert/strict";
import { test } from "node:test";
import { AdvanceMode, Code, PositionFormat, fractionsOf } from "../src/index.js";
import { bytesOf } from "../src/arrays.js";
import { checkDone } from "../src/check_answer.js";
import { frameMessage } from "../src/frame.js";
import { FrameDone } from "../src/generated/collided/v1/frame.js";
import { FrameOutput } from "../src/output.js";
import { checkShortened } from "../src/shortened.js";
import { refused } from "./support.js";

const ways = (ids: number[], fractions: number[]) => ({
  ids: bytesOf(Uint32Array.from(ids)),
  fractions: bytesOf(Float64Array.from(fractions)),
});
const size = { meshes: 4, vertices: 12, elements: 4 };

test("a frame says what goes its own fraction of the way", async () => {
  const { advance, advanceMode } = frameMessage({ advance: true, advanceMode: AdvanceMode.PER_VERTEX }, 1n, PositionFormat.F32);
  assert.deepEqual([advance, advanceMode], [true, AdvanceMode.PER_VERTEX]);
  assert.equal(frameMessage({ advance: true }, 1n, PositionFormat.F32).advanceMode, AdvanceMode.UNSPECIFIED);
  for (const bad of ["per_vertex", 4, -1, true]) {
    const call = () => frameMessage({ advance: true, advanceMode: bad as never }, 1n, PositionFormat.F32);
    const allowed = /it must be one of AdvanceMode.ALL_OR_ONE \(1\), AdvanceMode.PER_MESH \(2\), AdvanceMode.PER_VERTEX \(3\)/;
    await refused(call, Code.INVALID_ARGUMENT, "frame.advance_mode", allowed);
  }
});

test("what is shortened is joined from all messages, however their bytes are aligned", () => {
  const shifted = Uint8Array.from([9, ...ways([9], [0.25]).fractions]).subarray(1);
  const last = { ...ways([9], []), fractions: shifted };
  const done = FrameDone.create({ advanced: 0, way: 0.75, shortened: last });
  const output = new FrameOutput(1n, [], { done }, [ways([3], [0.5]), ways([4], [0])]);
  assert.deepEqual(output.shortened, { ids: Uint32Array.of(3, 4, 9), fractions: Float64Array.of(0.5, 0, 0.25) });
  assert.deepEqual([output.done.way, output.done.shortened], [0.75, undefined]);
  assert.deepEqual(fractionsOf(output.shortened, 4, 6), Float64Array.of(0, 1, 1, 1, 1, 0.25));
  assert.deepEqual(fractionsOf(output.shortened, 10, 2), Float64Array.of(1, 1));
  assert.deepEqual(fractionsOf(output.shortened, 0, 4), Float64Array.of(1, 1, 1, 0.5));
  assert.deepEqual(new FrameOutput(1n, [], {}).shortened, { ids: new Uint32Array(), fractions: new Float64Array() });
});

test("fractions of ids that cannot be are refused", async () => {
  const none = { ids: new Uint32Array(), fractions: new Float64Array() };
  await refused(() => fractionsOf(none, -1, 2), Code.INVALID_ARGUMENT, "first", /is -1/);
  await refused(() => fractionsOf(none, 0, 0.5), Code.INVALID_ARGUMENT, "count", /is 0.5/);
});

test("answers that cannot be are refused", async () => {
  const lost = (why: RegExp, call: () => unknown) => refused(call, Code.DATA_LOSS, "", why);
  for (const [why, ...messages] of [
    [/has 3 after 4; they must ascend strictly/, ways([4, 3], [0, 0])],
    [/has 3 after 3/, ways([3], [0]), ways([3], [0])],
    [/has 1; it must be in \[0, 1\)/, ways([3], [1])],
    [/has -0.5/, ways([3], [-0.5])],
    [/has NaN/, ways([3], [NaN])],
    [/4 bytes of ids and 0 of fractions/, ways([3], [])],
    [/0 bytes of ids and 8 of fractions/, ways([], [0])],
    [/3 bytes of ids and 6/, { ids: new Uint8Array(3), fractions: new Uint8Array(6) }],
  ] as [RegExp, ...ReturnType<typeof ways>[]][]) {
    const done = FrameDone.create({ shortened: messages.pop() });
    await lost(why, () => new FrameOutput(1n, [], { done }, messages));
  }
  await lost(/done.way is 1.5/, () => checkDone(FrameDone.create({ way: 1.5 })));
  await lost(/done.way is NaN/, () => checkDone(FrameDone.create({ way: NaN })));
});

test("only what the frame lets go its own way may be shortened", async () => {
  const shortened = (id: number) => ({ ids: Uint32Array.of(id), fractions: Float64Array.of(0.5) });
  const lost = (id: number, mode: AdvanceMode, why: RegExp) =>
    refused(() => checkShortened(shortened(id), mode, size), Code.DATA_LOSS, "", why);
  await lost(12, AdvanceMode.PER_VERTEX, /names 12; the frame has 12/);
  await lost(4, AdvanceMode.PER_MESH, /names 4; the frame has 4/);
  await lost(0, AdvanceMode.ALL_OR_ONE, /names 0; the frame has 0/);
  await lost(0, AdvanceMode.UNSPECIFIED, /names 0; the frame has 0/);
  checkShortened(shortened(11), AdvanceMode.PER_VERTEX, size);
  checkShortened(shortened(3), AdvanceMode.PER_MESH, size);
  checkShortened(shortened(99), AdvanceMode.PER_MESH); // the scene may have another size by now
  await refused(() => checkShortened(shortened(0), AdvanceMode.UNSPECIFIED), Code.DATA_LOSS, "");
});
