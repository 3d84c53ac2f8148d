// What callers pass to create a scene, and the messages that it becomes.

import { type Indices, packIndices } from "./arrays.js";
import { type Rules, anything, boolean, check, checkValue, finite, join, list, listOf } from "./check.js";
import { oneOf, show, string, uint32, uint64 } from "./check.js";
import { invalid } from "./errors.js";
import { ContactField, ContactKind } from "./generated/collided/v1/contact.js";
import {
  Accuracy,
  Backend,
  BroadPhaseEngine,
  DetectionMode,
  type MeshPair,
  MeshMotion,
  MeshSpec,
  PositionFormat,
  QuantizationBox,
  Report,
  Reuse,
  SceneSpec,
} from "./generated/collided/v1/scene.js";

/** A mesh of triangles, loose edges and loose points, of any of which it has one or more. Ids are numbered within it. */
export interface MeshInput {
  /** Unique in the scene, 1 to 128 bytes. In an edit it may be left out: the mesh's own stays. */
  name?: string;
  /** 1 to the daemon's limit. */
  vertexCount: number;
  /** Three vertices each. Any number: many are uploaded in chunks. */
  triangles?: Indices;
  /** Two vertices each, such as the segments of a hair. */
  edges?: Indices;
  /** A vertex each, such as particles. */
  points?: Indices;
  /** Deformable if left out. */
  motion?: MeshMotion;
  /** Bits of the groups that it is in; 0: the first. */
  groups?: number;
  /** Bits of the groups that it can touch; 0: all. */
  collideMask?: number;
  /** Leave out its contacts with itself. */
  noSelfContacts?: boolean;
  /** Leave out self contacts of features that so many edges or fewer connect, 0 to 8. */
  excludeRings?: number;
  /** Likewise of features within the scene's restDistance in its first frame. */
  excludeRestPairs?: boolean;
  /**
   * Half of what it is thick beyond the scene's thickness, >= 0, finite, in the unit of the positions: two meshes are in
   * contact up to the thickness and both halves, a mesh and itself up to the thickness and twice its half. 0 if left out.
   */
  halfThickness?: number;
  /**
   * The mesh bounds a volume. It has triangles alone, which use each edge as often in one direction as in the other. Its volume in its
   * first frame is above 0; normals (b - a) x (c - a) point outside. The daemon refuses other meshes. The default is false.
   */
  solid?: boolean;
}

/** A scene to create; proto/collided/v1/scene.proto describes each field of SceneSpec. */
export interface SceneInput {
  /** What counts as a contact: DCD, CCD or DCD_AND_CCD. */
  mode: DetectionMode;
  /** The meshes, in the order of their indices. */
  meshes: readonly MeshInput[];
  /** F32 if left out. */
  positionFormat?: PositionFormat;
  /** CERTIFIED if left out. */
  accuracy?: Accuracy;
  /** Contact distance, >= 0, in the unit of the positions. */
  thickness?: number;
  /** CCD: distance that `advance` keeps, >= 0. */
  minSeparation?: number;
  /** Tolerance of CCD from GUARDED on, >= 0; 0: relative to each pair's size. */
  delta?: number;
  /** Vertex-triangle and edge-edge if left out. */
  kinds?: readonly ContactKind[];
  /** Elements, stencil, and what the level computes of toi, distance and flags, if left out. */
  fields?: readonly ContactField[];
  /** What each frame reports; all contacts if left out. */
  report?: Report;
  /** Pairs of meshes, by index, that are not tested. */
  excludedMeshes?: readonly (readonly [number, number])[];
  /** Distance of excludeRestPairs; 0: each mesh's own contact distance, the thickness and twice its half. */
  restDistance?: number;
  /** Box of Q16 positions. */
  quantizationBox?: { lower: readonly number[]; upper: readonly number[] };
  /** CPU cores or a GPU; the daemon's default if left out. */
  backend?: Backend;
  /** Id of the device to live on, such as "cuda:1"; the daemon places the scene if left out. */
  device?: string;
  /** Ids of the devices to be spread over, a part on each, instead of `device`; pays in large scenes alone. */
  partDevices?: readonly string[];
  /** The daemon chooses if left out. */
  broadPhaseEngine?: BroadPhaseEngine;
  /** Whether frames that resemble the last reuse its list of neighbours; where it is faster if left out. */
  reuse?: Reuse;
  /** Bytes that the scene may hold; 0: the daemon's limit. */
  memoryBudgetBytes?: bigint | number;
  /** Contacts of a frame that room is made for at once, at most 2^32 - 1; 0: for few. */
  expectedContacts?: number;
  /** For people. */
  displayName?: string;
}

const MESH: Rules<MeshInput> = {
  name: string,
  vertexCount: uint32,
  triangles: anything,
  edges: anything,
  points: anything,
  motion: oneOf({ MeshMotion }),
  groups: uint32,
  collideMask: uint32,
  noSelfContacts: boolean,
  excludeRings: uint32,
  excludeRestPairs: boolean,
  halfThickness: finite,
  solid: boolean,
};

const SCENE: Rules<SceneInput> = {
  mode: oneOf({ DetectionMode }),
  meshes: list,
  positionFormat: oneOf({ PositionFormat }),
  accuracy: oneOf({ Accuracy }),
  thickness: finite,
  minSeparation: finite,
  delta: finite,
  kinds: listOf(oneOf({ ContactKind })),
  fields: listOf(oneOf({ ContactField })),
  report: oneOf({ Report }),
  excludedMeshes: list,
  restDistance: finite,
  quantizationBox: anything,
  backend: oneOf({ Backend }),
  device: string,
  partDevices: listOf(string),
  broadPhaseEngine: oneOf({ BroadPhaseEngine }),
  reuse: oneOf({ Reuse }),
  memoryBudgetBytes: uint64,
  expectedContacts: uint32,
  displayName: string,
};

/** The message of a mesh with its elements. */
export function meshSpec(mesh: MeshInput, path: string): MeshSpec {
  check(mesh, MESH, path);
  const { triangles, edges, points, ...rest } = mesh;
  const packed = packIndices(triangles, 3, join(path, "triangles"));
  return {
    ...MeshSpec.create(rest),
    triangles: packed,
    triangleCount: packed.length / 12,
    edges: packIndices(edges, 2, join(path, "edges")),
    points: packIndices(points, 1, join(path, "points")),
  };
}

/** The message of a scene. Its meshes have their triangles, which an upload may send instead. */
export function sceneSpec(scene: SceneInput): SceneSpec {
  check(scene, SCENE, "spec");
  if (!Array.isArray(scene.meshes)) throw invalid("spec.meshes", "is not there; a scene has one mesh or more");
  const { positionFormat = PositionFormat.F32, partDevices = [], kinds = [], fields = [], ...more } = scene;
  const { meshes, memoryBudgetBytes = 0, expectedContacts = 0, excludedMeshes, quantizationBox, ...rest } = more;
  return {
    ...SceneSpec.create(rest),
    positionFormat,
    partDevices: [...partDevices],
    kinds: [...kinds],
    fields: [...fields],
    memoryBudgetBytes: BigInt(memoryBudgetBytes),
    expectedContacts: BigInt(expectedContacts),
    meshes: meshes.map((mesh, i) => meshSpec(mesh, `spec.meshes[${i}]`)),
    excludedMeshes: meshPairs(excludedMeshes, "spec.excluded_meshes"),
    quantizationBox: boxOf(quantizationBox),
  };
}

/** Pairs of indices as messages. */
export function meshPairs(pairs: readonly (readonly [number, number])[] | undefined, path: string): MeshPair[] {
  return (pairs ?? []).map((pair, i) => {
    const isPair = Array.isArray(pair) && pair.length === 2 && pair.every((index) => uint32(index) === undefined);
    if (!isPair) throw invalid(`${path}[${i}]`, `is ${show(pair)}; it must be two indices of meshes`);
    return { first: pair[0], second: pair[1] };
  });
}

function boxOf(box: SceneInput["quantizationBox"]): QuantizationBox | undefined {
  if (box === undefined) return undefined;
  const path = "spec.quantization_box";
  check(box, { lower: anything, upper: anything }, path);
  checkValue(box.lower, listOf(finite), `${path}.lower`);
  checkValue(box.upper, listOf(finite), `${path}.upper`);
  return { lower: [...box.lower], upper: [...box.upper] };
}
