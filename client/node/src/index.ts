// The public API.

export { connect, type Client, type CreateOptions } from "./client.js";
export type { ConnectOptions } from "./connection.js";
export { OwnDaemon, findDaemon } from "./daemon.js";
export { Code, CollidedError, type ErrorDetails } from "./errors.js";
export type { Indices, Positions, RigidMatrix } from "./arrays.js";
export type { MeshInput, SceneInput } from "./scene.js";
export type { MeshElements } from "./mesh_elements.js";
export type { FrameInput, MeshEditInput, MeshUpdateInput, SceneEditInput } from "./frame.js";
export type { Contact, Contacts, ContactsByKind } from "./contacts.js";
export type { FrameOutput } from "./output.js";
export type { PairOfMeshes } from "./pairs.js";
export { type Shortened, fractionsOf } from "./shortened.js";
export type { FrameStream, StreamOptions } from "./stream.js";
export type { Session, SessionOptions } from "./session.js";
export type { SampledPositions, WatchOptions, WatchedFrame, Watcher } from "./watcher.js";
export { ClosestFeature, EdgePlace, TrianglePlace, kept, placeOnTriangle, placesOnEdges } from "./closest.js";
export { type ContactPoints, type ElementKind, contactPoints, elementKind } from "./points.js";
export { type RealPositions, moveAlong, moveRigidly, packQuantized, poseAlong, unpackQuantized } from "./positions.js";

export { ContactField, ContactFlag, ContactKind, MeshPairState } from "./generated/collided/v1/contact.js";
export { AdvanceMode, type FrameDone } from "./generated/collided/v1/frame.js";
export type { FrameMetrics } from "./generated/collided/v1/metrics.js";
export {
  Accuracy,
  Backend,
  BroadPhaseEngine,
  DetectionMode,
  MeshMotion,
  PositionFormat,
  Report,
  Reuse,
  SceneState,
} from "./generated/collided/v1/scene.js";
export type { QuantizationBox, Scene, SceneSpec } from "./generated/collided/v1/scene.js";
export {
  DeliveryPolicy,
  type EstimateSceneResponse,
  type GetServerInfoResponse,
  type ServerLimits,
} from "./generated/collided/v1/collision_service.js";
