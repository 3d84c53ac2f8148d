import assert from "node:assert/strict";
import { test } from "node:test";
import {
  Accuracy,
  ClosestFeature,
  Code,
  ContactField,
  ContactFlag,
  ContactKind,
  DetectionMode,
  EdgePlace,
  type FrameInput,
  PositionFormat,
  Report,
  type Scene,
  type SceneInput,
  TrianglePlace,
  kept,
  placeOnTriangle,
  placesOnEdges,
} from "../src/index.js";
import { FLOOR, TWO_TRIANGLES, fall, refused, sheets, tipAt, useDaemon } from "./support.js";

const used = useDaemon(["--max-message-mb", "4"]);

async function withScene(use: (scene: Scene) => Promise<void>, more: object = {}): Promise<void> {
  const scene = await used.client.createScene({ ...TWO_TRIANGLES, ...more });
  await use(scene);
  await used.client.deleteScene(scene);
}

test("a contact is where it was built in", () =>
  withScene(async (scene) => {
    const output = await used.client.detect(scene, fall(2, { frameId: 1 }));
    const { vertexTriangle: contacts, edgeEdge, triangleTriangle, done } = output;
    assert.deepEqual([contacts.count, edgeEdge.count, triangleTriangle.count], [1, 0, 0]);
    assert.deepEqual([contacts.length, edgeEdge.length, [...edgeEdge]], [1, 0, []]);
    const [{ elements, stencil, toi, weights, normal, flags }, ...others] = contacts;
    assert.deepEqual([elements, stencil, toi, flags, others], [[3, 0], [3, 0, 1, 2], contacts.toi[0], contacts.flags[0], []]);
    assert.deepEqual([weights?.length, normal?.length], contacts.weights.length > 0 ? [2, 3] : [undefined, undefined]);
    assert.deepEqual(
      [[...contacts.elements], [...contacts.stencils]],
      [
        [3, 0],
        [3, 0, 1, 2],
      ],
    );
    assert(contacts.toi[0] <= 0.5 && contacts.toi[0] > 0.499);
    assert.equal(contacts.flags[0] & ContactFlag.INITIAL, 0);
    assert.notEqual(contacts.flags[0] & ContactFlag.CERTIFIED, 0);
    assert.deepEqual([done.contactCount, done.earliestToi, done.anyContact], [1n, contacts.toi[0], true]);
    assert(done.metrics!.stages.length > 0);
  }));

// Two triangles with the corner 0, of which the second one goes through the first.
test("an edge goes through a neighbour", async () => {
  const { VERTEX_TRIANGLE, EDGE_EDGE, TRIANGLE_TRIANGLE, EDGE_TRIANGLE } = ContactKind;
  const folded: SceneInput = {
    mode: DetectionMode.DCD,
    accuracy: Accuracy.EXACT,
    positionFormat: PositionFormat.F64,
    kinds: [VERTEX_TRIANGLE, EDGE_EDGE, TRIANGLE_TRIANGLE, EDGE_TRIANGLE],
    fields: [ContactField.ELEMENTS, ContactField.WEIGHTS, ContactField.FLAGS],
    meshes: [{ name: "folded", vertexCount: 5, triangles: [0, 1, 2, 0, 3, 4] }],
  };
  const scene = await used.client.createScene(folded);
  const positions = Float64Array.of(0, 0, 0, 4, 0, 0, 0, 4, 0, 2, 1, -1, 2, 1.5, 2);
  const { edgeTriangle, triangleTriangle, done } = await used.client.detect(scene, { frameId: 1, updates: [{ mesh: 0, positions }] });
  assert.deepEqual([[...edgeTriangle.elements], [...edgeTriangle.flags]], [[5, 0], [ContactFlag.CERTIFIED]]);
  assert(Math.abs(edgeTriangle.weights[0] - 1 / 2) < 1e-12 && Math.abs(edgeTriangle.weights[1] - 7 / 24) < 1e-12);
  assert.deepEqual([...triangleTriangle.elements], [0, 1]);
  assert.equal(done.contactCount, 2n);
  await used.client.deleteScene(scene);
  const moving = { ...folded, mode: DetectionMode.CCD, kinds: [VERTEX_TRIANGLE, EDGE_EDGE, EDGE_TRIANGLE] };
  await refused(() => used.client.createScene(moving), Code.INVALID_ARGUMENT, "spec.kinds[2]", /EDGE_TRIANGLE/);
});

// A tip stands above the diagonal of a square.
test("of a vertex above a side one contact is kept", async () => {
  const scene = await used.client.createScene({
    mode: DetectionMode.DCD,
    thickness: 0.02,
    positionFormat: PositionFormat.F64,
    fields: [ContactField.ELEMENTS, ContactField.FLAGS, ContactField.FEATURES],
    meshes: [
      { name: "floor", vertexCount: 4, triangles: [0, 1, 2, 0, 2, 3] },
      { name: "spike", vertexCount: 3, triangles: [0, 1, 2] },
    ],
  });
  const square = Float64Array.of(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0);
  const spike = Float64Array.of(0.5, 0.5, 0.001, 0.25, 0.5, 1, 0.75, 0.625, 1);
  const updates = [square, spike].map((positions, mesh) => ({ mesh, positions }));
  const { vertexTriangle, edgeEdge } = await used.client.detect(scene, { frameId: 1, updates });
  assert.deepEqual([...vertexTriangle.elements], [4, 0, 4, 1]);
  assert.deepEqual([...vertexTriangle.features].map(placeOnTriangle), [TrianglePlace.SIDE_2, TrianglePlace.SIDE_3]);
  assert.deepEqual(placesOnEdges(edgeEdge.features[0]), [EdgePlace.INSIDE, EdgePlace.END_1]);
  assert((vertexTriangle.features[1] & ClosestFeature.SAME_AS_BEFORE) !== 0);
  assert.deepEqual([kept(vertexTriangle), kept(edgeEdge)], [[0], []]);
  await used.client.deleteScene(scene);
});

test("ids have all their 64 bits", () =>
  withScene(async (scene) => {
    for (const frameId of [2n ** 53n + 1n, 2n ** 63n - 1n]) {
      assert.equal((await used.client.detect(scene, fall(2, { frameId }))).frameId, frameId);
      assert.equal((await used.client.getScene(scene.sceneId)).lastFrameId, frameId);
    }
    await refused(() => used.client.detect(scene, fall(2, { frameId: 2n ** 63n })), Code.INVALID_ARGUMENT, "frame.frame_id");
    await refused(
      () => used.client.detect(scene, fall(2, { frameId: 2 ** 53 })),
      Code.INVALID_ARGUMENT,
      "frame.frame_id",
      /2\^53 - 1/,
    );
    await refused(() => used.client.detect(scene, fall(2)), Code.INVALID_ARGUMENT, "frame.frame_id", /is undefined/);
  }));

test("options hold for their frame alone", () =>
  withScene(async (scene) => {
    const stream = await used.client.stream(scene);
    const hit = await stream.detect(fall(2, { report: Report.ANY_HIT, accuracy: Accuracy.FAST, delta: 1e-3 }));
    assert.deepEqual([hit.vertexTriangle.count, hit.done.anyContact], [0, true]);
    assert.equal((await stream.detect(fall(4, { trial: true }))).vertexTriangle.count, 1);
    assert.equal((await stream.detect(fall(0.5))).vertexTriangle.count, 0);
    await stream.finish();
  }));

test("a frame that is refused leaves the stream open", () =>
  withScene(async (scene) => {
    const stream = await used.client.stream(scene);
    await stream.detect(fall(2));
    const bad = tipAt(1);
    bad[5] = NaN;
    const one = (update: object): FrameInput => ({ updates: [update as never] });
    const cases: [FrameInput, string, RegExp][] = [
      [one({ mesh: 1, positions: bad }), "frame.updates[0].positions", /nan/i],
      [one({ mesh: 1, positions: tipAt(1).subarray(3) }), "frame.updates[0].positions", /24/],
      [one({ mesh: 7, positions: FLOOR }), "frame.updates[0].mesh", /7/],
      [one({ mesh: -1, positions: FLOOR }), "frame.updates[0].mesh", /is -1; it must be an integer/],
      [one({ positions: FLOOR }), "frame.updates[0].mesh", /is undefined/],
      [one({ mesh: 1, position: FLOOR }), "frame.updates[0].position", /is not known/],
      [
        one({ mesh: 1, positions: new Float64Array(9) }),
        "frame.updates[0].positions",
        /is a Float64Array; position_format F32 needs a Float32Array/,
      ],
      [one({ mesh: 1, positions: [1, 2, 3] }), "frame.updates[0].positions", /an array of 3/],
      [one({ mesh: 1, positions: FLOOR, transform: [1, 2] }), "frame.updates[0].rigid.matrix", /12 finite numbers/],
      [
        one({ mesh: 1, startTransform: new Float64Array(12) }),
        "frame.updates[0].rigid.start_matrix",
        /\(startTransform\) is set, which needs transform/,
      ],
      [{ updates: {} as never }, "frame.updates", /must be an array/],
      [fall(2, { delta: Infinity }), "frame.delta", /finite/],
      [fall(2, { frameId: 1 }), "frame.frame_id", /./],
      [fall(2, { fromLastFraction: 2 }), "frame.from_last_fraction", /2/],
    ];
    for (const [frame, field, message] of cases) {
      const code = field === "frame.frame_id" ? Code.FAILED_PRECONDITION : Code.INVALID_ARGUMENT;
      await refused(() => stream.detect(frame), code, field, message);
    }
    assert.equal((await stream.detect(fall(4))).vertexTriangle.count, 1);
    await stream.finish();
  }));

test("a frame that is too large is refused before it is sent", async () => {
  const { scene, positions } = sheets(60);
  const created = await used.client.createScene(scene);
  const stream = await used.client.stream(created);
  const updates = positions.map((of, mesh) => ({ mesh, positions: of }));
  const limit = used.client.serverInfo.limits!.maxMessageBytes;
  const many = Array.from({ length: Number(limit) / positions[0].byteLength + 1 }, () => updates[0]);
  await refused(() => stream.detect({ updates: many }), Code.RESOURCE_EXHAUSTED, "frame", /bytes; the daemon's limit is \d+/);
  assert.equal((await stream.detect({ updates, report: Report.ANY_HIT })).done.anyContact, true);
  await stream.finish();
  await used.client.deleteScene(created);
});

test("contacts of many chunks are the same over every call, however their bytes are aligned", async () => {
  const { scene, positions } = sheets(40);
  const updates = positions.map((of, mesh) => ({ mesh, positions: of }));
  const created = await used.client.createScene({ ...scene, fields: [1, 2, 4, 5, 7] });
  const unary = await used.client.detect(created, { frameId: 1, updates, trial: false, report: Report.ANY_HIT });
  assert.equal(unary.done.anyContact, true);
  const stream = await used.client.stream(created, { window: 2 });
  const first = await stream.detect({ updates });
  const second = await stream.detect({ updates });
  assert(first.done.metrics!.bytesOut > 2n << 20n, "one chunk is no test");
  for (const kind of ["vertexTriangle", "edgeEdge"] as const) {
    const { count, elements, stencils, distance, weights, flags, toi } = first[kind];
    const lengths = [elements, stencils, distance, weights, flags, toi].map((array) => array.length);
    assert.deepEqual(
      lengths,
      [2, 4, 1, 2, 1, 0].map((entries) => entries * count),
    );
    assert.deepEqual(second[kind], first[kind]);
  }
  await stream.finish();
  await used.client.deleteScene(created);
});

test("positions go as they are, from any part of a buffer", () =>
  withScene(
    async (scene) => {
      const all = new Float64Array([9, ...FLOOR, ...tipAt(1), ...tipAt(-1)]);
      const [floor, start, end] = [1, 10, 19].map((at) => all.subarray(at, at + 9));
      const updates = [
        { mesh: 0, positions: floor },
        { mesh: 1, startPositions: start, positions: end },
      ];
      const { vertexTriangle } = await used.client.detect(scene, { frameId: 1, updates });
      assert.deepEqual([...vertexTriangle.elements], [3, 0]);
    },
    { positionFormat: PositionFormat.F64 },
  ));
