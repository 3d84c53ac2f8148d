import assert from "node:assert/strict";
import { test } from "node:test";
import { Accuracy, Code, ContactField, DetectionMode, PositionFormat, SceneState, connect } from "../src/index.js";
import { FLOOR, TWO_TRIANGLES, fall, refused, sheets, tipAt, useDaemon } from "./support.js";

const used = useDaemon(["--max-message-mb", "4"]); // room for 2 MiB of triangles in the message that creates a scene
const [floor, tip] = TWO_TRIANGLES.meshes;

test("the daemon tells its version, devices and limits", async () => {
  const info = await used.client.getServerInfo();
  assert.match(info.version, /^\d+\.\d+/);
  assert.equal(typeof info.limits?.maxMessageBytes, "bigint");
  assert.deepEqual(used.client.serverInfo.devices, info.devices);
});

test("a scene is created, listed, estimated and deleted", async () => {
  const { client } = used;
  const scene = await client.createScene(TWO_TRIANGLES, { leaseSeconds: 60 });
  assert.equal(scene.state, SceneState.READY);
  assert.deepEqual([scene.vertexCount, scene.edgeCount, scene.triangleCount, scene.leaseSeconds], [6n, 6n, 2n, 60]);
  assert.equal(scene.spec?.accuracy, Accuracy.CERTIFIED);
  assert.equal((await client.getScene(scene.sceneId)).sceneId, scene.sceneId);
  assert((await client.listScenes()).some(({ sceneId }) => sceneId === scene.sceneId));
  const estimate = await client.estimateScene(TWO_TRIANGLES);
  assert.deepEqual([estimate.vertexCount, estimate.triangleCount, estimate.firstFrameBytes], [6n, 2n, 72n]);
  await client.deleteScene(scene);
  await refused(() => client.getScene(scene.sceneId), Code.NOT_FOUND, "scene_id");
});

test("triangles go with the scene or in chunks, whole ones, however many there are, and can be read again", async () => {
  const { scene } = sheets(230); // 1.27 MB of triangles a mesh: one goes with the scene, the other in two chunks
  const created = await used.client.createScene(scene);
  assert.equal(created.state, SceneState.READY);
  assert.equal(created.triangleCount, 2n * 2n * 230n * 230n);
  for (const mesh of [0, 1]) assert.deepEqual((await used.client.getMesh(created, mesh)).elements, scene.meshes[mesh].triangles);
  await used.client.deleteScene(created);
});

test("meshes that are too large for the message are uploaded together", async () => {
  const strip = (i: number) => Array.from({ length: 60_000 }, (_, at) => [at % 5000, (at % 5000) + 1 + (i % 2), (at % 5000) + 2 - (i % 2)]).flat();
  const meshes = Array.from({ length: 10 }, (_, i) => ({ name: `mesh ${i}`, vertexCount: 5_002, triangles: strip(i) }));
  const scene = await used.client.createScene({ mode: DetectionMode.DCD, meshes });
  assert.equal(scene.state, SceneState.READY);
  for (const [i, mesh] of meshes.entries()) assert.deepEqual([...(await used.client.getMesh(scene, i)).elements], mesh.triangles);
  await used.client.deleteScene(scene);
});

test("what a mesh is made of is told to whoever asks", async () => {
  const hair = { name: "hair", vertexCount: 6, triangles: [0, 1, 2], edges: [2, 3, 3, 4], points: [5] };
  const scene = await used.client.createScene({ mode: DetectionMode.CCD, meshes: [hair] });
  const mesh = await used.client.getMesh(scene.sceneId, 0);
  assert.deepEqual([...mesh.elements], [0, 1, 2, 2, 3, 3, 3, 4, 4, 5, 5, 5]);
  assert.deepEqual([mesh.vertexCount, mesh.editCount], [6, 0n]);
  await refused(() => used.client.getMesh(scene, 1), Code.INVALID_ARGUMENT, "mesh");
  await refused(() => used.client.getMesh(scene, -1), Code.INVALID_ARGUMENT, "mesh", /is -1/);
  await refused(() => used.client.getMesh("none", 0), Code.NOT_FOUND, "scene_id");
  await used.client.deleteScene(scene);
});

test("a refused upload leaves no scene", async () => {
  const before = (await used.client.listScenes()).length;
  const large = Array.from({ length: 180_000 }, () => [0, 1, 2]).flat();
  for (const [triangles, field] of [
    [[0, 1, 7], "spec.meshes[1].triangles[0]"],
    [[...large, 0, 1, 7], "triangles[180000]"],
  ] as const) {
    const meshes = [floor, { ...tip, triangles }];
    await refused(() => used.client.createScene({ ...TWO_TRIANGLES, meshes }), Code.INVALID_ARGUMENT, field);
  }
  assert.equal((await used.client.listScenes()).length, before);
});

test("a value that cannot be is refused by name before anything is sent", async () => {
  const cases: [object, string, RegExp][] = [
    [{ thicknes: 0.1 }, "spec.thicknes", /is not known; spec has mode, .*thickness/],
    [{ mode: "CCD" }, "spec.mode", /is "CCD"; it must be one of DetectionMode.DCD \(1\), DetectionMode.CCD \(2\), \S+ \(3\)$/],
    [{ report: -1 }, "spec.report", /is -1; it must be one of Report\.ALL/],
    [{ displayName: "\ud800" }, "spec.display_name", /a string of whole characters/],
    [{ mode: 77 }, "spec.mode", /is 77; it must be one of/],
    [{ thickness: "0.1" }, "spec.thickness", /is "0.1"; it must be a finite number/],
    [{ thickness: NaN }, "spec.thickness", /is NaN/],
    [
      { meshes: [floor, { ...tip, halfThickness: Infinity }] },
      "spec.meshes[1].half_thickness",
      /is Infinity; it must be a finite number/,
    ],
    [{ memoryBudgetBytes: -1n }, "spec.memory_budget_bytes", /is -1; it must be a bigint from 0/],
    [{ memoryBudgetBytes: 2 ** 60 }, "spec.memory_budget_bytes", /up to 2\^53 - 1/],
    [{ kinds: [1, 9] }, "spec.kinds", /\[1\], 9, one of/],
    [{ fields: ContactField.TOI }, "spec.fields", /must be an array/],
    [{ meshes: floor }, "spec.meshes", /must be an array/],
    [{ meshes: [floor, null] }, "spec.meshes[1]", /is null; it must be an object/],
    [
      { meshes: [{ ...floor, vertexCount: -3 }] },
      "spec.meshes[0].vertex_count",
      /is -3; it must be an integer from 0 to 4294967295/,
    ],
    [{ meshes: [{ ...floor, vertexCount: 2.5 }] }, "spec.meshes[0].vertex_count", /is 2.5/],
    [{ meshes: [{ ...floor, triangles: [0, 1, -1] }] }, "spec.meshes[0].triangles[2]", /is -1/],
    [{ meshes: [{ ...floor, triangles: [0, 1] }] }, "spec.meshes[0].triangles", /has 2 indices, which is no multiple of 3/],
    [
      { meshes: [{ ...floor, triangles: new Int32Array(3) }] },
      "spec.meshes[0].triangles",
      /is a Int32Array; it must be a Uint32Array/,
    ],
    [{ meshes: [{ ...floor, edges: new Uint32Array(3) }] }, "spec.meshes[0].edges", /multiple of 2/],
    [{ excludedMeshes: [[0]] }, "spec.excluded_meshes[0]", /must be two indices/],
    [{ quantizationBox: { lower: [0, 0, 0], upper: "1" } }, "spec.quantization_box.upper", /must be an array/],
    [{ quantizationBox: { lower: [0, 0, 0] } }, "spec.quantization_box.upper", /is undefined; it must be an array/],
  ];
  for (const [more, field, message] of cases) {
    await refused(() => used.client.createScene({ ...TWO_TRIANGLES, ...more }), Code.INVALID_ARGUMENT, field, message);
  }
  await refused(() => used.client.createScene(TWO_TRIANGLES, { lease: 3 } as never), Code.INVALID_ARGUMENT, "options.lease");
  await refused(() => used.client.createScene(undefined as never), Code.INVALID_ARGUMENT, "spec");
  await refused(() => used.client.deleteScene({} as never), Code.INVALID_ARGUMENT, "scene");
});

test("what only the daemon knows, it refuses by name", async () => {
  const cases: [object, Code, string][] = [
    [{ mode: DetectionMode.UNSPECIFIED }, Code.INVALID_ARGUMENT, "spec.mode"],
    [{ meshes: [] }, Code.INVALID_ARGUMENT, "spec.meshes"],
    [{ meshes: [floor, floor] }, Code.INVALID_ARGUMENT, "spec.meshes[1].name"],
    [{ thickness: -1 }, Code.INVALID_ARGUMENT, "spec.thickness"],
    [{ meshes: [floor, { ...tip, halfThickness: -1 }] }, Code.INVALID_ARGUMENT, "spec.meshes[1].half_thickness"],
    [{ meshes: [floor, { ...tip, halfThickness: 1e300 }] }, Code.INVALID_ARGUMENT, "spec.meshes[1].half_thickness"],
    [{ positionFormat: PositionFormat.Q16 }, Code.INVALID_ARGUMENT, "spec.quantization_box"],
    [{ memoryBudgetBytes: 1 }, Code.RESOURCE_EXHAUSTED, "spec.memory_budget_bytes"],
  ];
  for (const [more, code, field] of cases)
    await refused(() => used.client.createScene({ ...TWO_TRIANGLES, ...more }), code, field);
  await refused(() => used.client.getScene("no such scene"), Code.NOT_FOUND, "scene_id");
});

test("meshes touch up to the thickness and both halves", async () => {
  const updates = [
    { mesh: 0, positions: FLOOR },
    { mesh: 1, positions: tipAt(1) },
  ];
  for (const [first, second, count] of [
    [0, 0, 0],
    [0.25, 0.25, 1],
    [0.25, 0.249, 0],
    [0, 0.5, 1],
  ]) {
    const meshes = [
      { ...floor, halfThickness: first },
      { ...tip, halfThickness: second },
    ];
    const scene = await used.client.createScene({ mode: DetectionMode.DCD, thickness: 0.5, meshes });
    assert.equal(scene.spec?.meshes[1]?.halfThickness, second);
    const stream = await used.client.stream(scene);
    assert.equal((await stream.detect({ updates })).vertexTriangle.count, count);
    const edit = { meshes: [{ mesh: 1, spec: { vertexCount: 3, halfThickness: 0.75 } }] };
    assert.equal((await stream.detect({ edit })).vertexTriangle.count, 1);
    await stream.finish();
  }
});

test("a client of its own daemon ends with it", async () => {
  const client = await connect();
  const scene = await client.createScene(TWO_TRIANGLES);
  assert.equal((await client.detect(scene, fall(2, { frameId: 1 }))).vertexTriangle.count, 1);
  await client.close();
  await refused(() => client.getServerInfo(), Code.FAILED_PRECONDITION, "", /closed/);
});
