// What callers pass as a frame, and the message that it becomes.

import { type Indices, type Positions, type RigidMatrix, packIndices, packMatrix, packPositions } from "./arrays.js";
import { type Rules, anything, boolean, check, checkValue, finite, join, list, oneOf, uint32, uint64 } from "./check.js";
import { invalid } from "./errors.js";
import { AdvanceMode, Frame, MeshUpdate } from "./generated/collided/v1/frame.js";
import { Accuracy, DetectionMode, type PositionFormat, Report, type SceneEdit } from "./generated/collided/v1/scene.js";
import { type MeshInput, meshPairs, meshSpec } from "./scene.js";

/** New positions of one mesh, or the pose of a rigid one. */
export interface MeshUpdateInput {
  /** Index in the scene's spec. */
  mesh: number;
  /** At t = 1: of all vertices, or of those of `indices`. Their type is that of the scene's format. */
  positions?: Positions;
  /** At t = 0 (CCD), as many; left out: where the last frame ended. */
  startPositions?: Positions;
  /** Strictly ascending: only these vertices change. */
  indices?: Indices;
  /** At t = 1: moves a rigid mesh's first positions. */
  transform?: RigidMatrix;
  /** At t = 0 (CCD), with `transform`; left out: where the last frame left the mesh. */
  startTransform?: RigidMatrix;
}

/** A mesh as an edit wants it: of `spec` from now on; without one it is removed. */
export interface MeshEditInput {
  /** Index of a mesh, of one that was removed, or the number of meshes, to add one. */
  mesh: number;
  /** Without triangles, edges and points the mesh keeps those that it has. */
  spec?: MeshInput;
}

/** Changes of what the scene is made of: client/EDITING.md. */
export interface SceneEditInput {
  meshes?: readonly MeshEditInput[];
  /** Pairs that are not tested from now on. */
  excludeMeshes?: readonly (readonly [number, number])[];
  /** Pairs that are tested again. */
  includeMeshes?: readonly (readonly [number, number])[];
}

/** One step. What is not set is the scene's; proto/collided/v1/frame.proto describes each field of Frame. */
export interface FrameInput {
  /** Greater than the last frame's, 1 to 2^63 - 1. On a stream it may be left out: one more than the last one's. */
  frameId?: bigint | number;
  /** Meshes that moved. A scene's first frame names every mesh. */
  updates?: readonly MeshUpdateInput[];
  /** Question of this frame in scenes of DCD_AND_CCD. */
  mode?: DetectionMode;
  accuracy?: Accuracy;
  delta?: number;
  report?: Report;
  /** Leave SEPARATING contacts out of earliestToi, EARLIEST_ONLY and ANY_HIT. */
  ignoreSeparating?: boolean;
  /** Go only as far as is certified; `done.advanced` tells how far, and moveAlong moves your copy likewise. */
  advance?: boolean;
  /** What goes its own fraction of the way, with `advance` alone: the scene, or each mesh, or each vertex (`output.shortened`). */
  advanceMode?: AdvanceMode;
  /** Answer with the contacts that limit the way, too, with `advance` alone: `output.limits`. */
  limits?: boolean;
  /** Answer, and leave the scene as it was. */
  trial?: boolean;
  /** Begin this far along the way of the last frame, in [0, 1]. */
  fromLastFraction?: number;
  edit?: SceneEditInput;
}

const FRAME: Rules<FrameInput> = {
  frameId: uint64,
  updates: list,
  mode: oneOf({ DetectionMode }),
  accuracy: oneOf({ Accuracy }),
  delta: finite,
  report: oneOf({ Report }),
  ignoreSeparating: boolean,
  advance: boolean,
  advanceMode: oneOf({ AdvanceMode }),
  limits: boolean,
  trial: boolean,
  fromLastFraction: finite,
  edit: anything,
};

const UPDATE: Rules<MeshUpdateInput> = {
  mesh: uint32,
  positions: anything,
  startPositions: anything,
  indices: anything,
  transform: anything,
  startTransform: anything,
};

/** The message of a frame of a scene with positions of `format`. */
export function frameMessage(input: FrameInput, frameId: bigint, format: PositionFormat): Frame {
  check(input, FRAME, "frame");
  const { updates = [], edit, ...options } = input;
  return {
    ...Frame.create(options),
    frameId,
    updates: updates.map((update, i) => updateMessage(update, format, `frame.updates[${i}]`)),
    edit: edit === undefined ? undefined : editMessage(edit, "frame.edit"),
  };
}

/** The id of a frame that names one. */
export function frameIdOf(input: FrameInput): bigint {
  checkValue(input?.frameId, uint64, "frame.frame_id");
  return BigInt(input.frameId as bigint);
}

function updateMessage(input: MeshUpdateInput, format: PositionFormat, path: string): MeshUpdate {
  check(input, UPDATE, path);
  checkValue(input.mesh, uint32, join(path, "mesh"));
  const { indices, transform, startTransform } = input;
  if (startTransform !== undefined && transform === undefined) {
    throw invalid(join(path, "rigid.startMatrix"), "(startTransform) is set, which needs transform");
  }
  return {
    ...MeshUpdate.create({ mesh: input.mesh }),
    positions: packPositions(input.positions, format, join(path, "positions")),
    startPositions: packPositions(input.startPositions, format, join(path, "startPositions")),
    sparse:
      indices === undefined ? undefined : { indices: packIndices(indices, 1, join(path, "sparse.indices")), sharedIndices: undefined },
    rigid:
      transform === undefined
        ? undefined
        : {
            matrix: packMatrix(transform, join(path, "rigid.matrix")),
            startMatrix: packMatrix(startTransform, join(path, "rigid.startMatrix")),
          },
  };
}

function editMessage(input: SceneEditInput, path: string): SceneEdit {
  check(input, { meshes: list, excludeMeshes: list, includeMeshes: list }, path);
  const { meshes = [], excludeMeshes, includeMeshes } = input;
  return {
    meshes: meshes.map((mesh, i) => {
      const at = `${path}.meshes[${i}]`;
      check(mesh, { mesh: uint32, spec: anything }, at);
      checkValue(mesh.mesh, uint32, `${at}.mesh`);
      return { mesh: mesh.mesh, spec: mesh.spec === undefined ? undefined : meshSpec(mesh.spec, `${at}.spec`) };
    }),
    excludeMeshes: meshPairs(excludeMeshes, `${path}.exclude_meshes`),
    includeMeshes: meshPairs(includeMeshes, `${path}.include_meshes`),
  };
}
