// These checks guard everything that is computed from an answer: the daemon may be wrong, or another program may answer.

import type { Contacts, ContactsByKind, ContactsField } from "./contacts.js";
import { Code, CollidedError } from "./errors.js";
import { ContactKind } from "./generated/collided/v1/contact.js";
import type { FrameDone } from "./generated/collided/v1/frame.js";
import type { Scene, SceneSpec } from "./generated/collided/v1/scene.js";
import type { FrameOutput } from "./output.js";
import type { PairOfMeshes } from "./pairs.js";

/** That any daemon lets be in flight. */
export const MOST_FRAMES = 1024;
/** Scenes that a daemon can have. */
export const MOST_SCENES = 1_000_000;
/** Contacts of chunks without any array, whose number nothing confirms. */
const MOST_BARE = 1 << 24;

/** How many meshes, vertices and elements a scene has. */
export interface SceneSize {
  meshes: number;
  vertices: number;
  elements: number;
}

export function sizeOf(spec: SceneSpec | undefined): SceneSize {
  const size = { meshes: spec?.meshes.length ?? 0, vertices: 0, elements: 0 };
  for (const mesh of spec?.meshes ?? []) {
    size.vertices += mesh.vertexCount;
    size.elements += mesh.triangleCount + mesh.edgeCount + mesh.pointCount;
  }
  return size;
}

export function dataLoss(message: string): CollidedError {
  return new CollidedError(Code.DATA_LOSS, message);
}

/** The scene of an answer. Throws (DATA_LOSS) if it has none. */
export function sceneOf(answer: { scene?: Scene | undefined }): Scene {
  if (answer.scene?.sceneId && answer.scene.spec) return answer.scene;
  throw dataLoss("the daemon's answer has no scene");
}

/** Times and fractions of a frame's end. */
export function checkDone(done: FrameDone | undefined): FrameDone {
  if (!done) throw dataLoss("an answer has no `done`");
  if (!isFraction(done.earliestToi)) throw dataLoss(`done.earliest_toi is ${done.earliestToi}; it must be in [0, 1]`);
  if (!isFraction(done.advanced ?? 0)) throw dataLoss(`done.advanced is ${done.advanced}; it must be in [0, 1]`);
  if (!isFraction(done.way ?? 0)) throw dataLoss(`done.way is ${done.way}; it must be in [0, 1]`);
  return done;
}

/** As many contacts came as the daemon says that it sent. */
export function checkTotal(done: FrameDone, contacts: ContactsByKind): void {
  const { vertexTriangle, edgeEdge, triangleTriangle, edgeTriangle, vertexSolid } = contacts;
  const came = vertexTriangle.count + edgeEdge.count + triangleTriangle.count + edgeTriangle.count + vertexSolid.count;
  if (done.contactCount !== BigInt(came)) throw dataLoss(`done.contact_count is ${done.contactCount}, and ${came} contacts came`);
}

/** Limits came only if the frame asked for them. */
export function checkAsked({ vertexTriangle, edgeEdge }: ContactsByKind, isAsked: boolean): void {
  const came = vertexTriangle.count + edgeEdge.count;
  if (came > 0 && !isAsked) throw dataLoss(`limits has ${came} contacts, and the frame did not ask for them`);
}

/** Times and distances of contacts of a kind, and a count that no array confirms where they are bare. `of`: the field of the answer. */
export function checkNumbers(contacts: Contacts, kind: ContactKind, of: ContactsField, isBare: boolean): void {
  const time = contacts.toi.find((toi) => !isFraction(toi));
  if (time !== undefined) throw dataLoss(`${of}.toi has ${time}; it must be in [0, 1]`);
  checkDistances(contacts, kind, of);
  if (isBare && contacts.count > MOST_BARE) {
    throw dataLoss(`${of}.count is ${contacts.count} in all without any array; it must be at most ${MOST_BARE}`);
  }
}

/** Depths are below 0, all other distances 0 or more, and a sign changes nothing else. */
function checkDistances({ distance, signedDistances }: Contacts, kind: ContactKind, of: ContactsField): void {
  const isDepth = kind === ContactKind.VERTEX_SOLID;
  const bad = distance.find((each) => (isDepth ? !(each < 0) : !(each >= 0)));
  if (bad !== undefined) throw dataLoss(`${of}.distance has ${bad}; it must be ${isDepth ? "below 0 in a solid" : "0 or more"}`);
  if (distance.length === 0) return;
  const other = signedDistances.findIndex((each, i) => !Number.isNaN(each) && Math.abs(each) !== distance[i]);
  if (other < 0) return;
  throw dataLoss(`${of}.signed_distances has ${signedDistances[other]}; it must be ${distance[other]}, its distance, or minus it`);
}

/** The scene has what a frame's contacts, limits and pairs name. A size of 0 is not known. */
export function checkIds(output: Pick<FrameOutput, keyof ContactsByKind | "limits" | "pairs">, size: SceneSize): void {
  if (size.vertices === 0) return;
  checkPairs(output.pairs, size);
  checkIdsOf(output, size, "contacts");
  checkIdsOf(output.limits, size, "limits");
}

function checkIdsOf(contacts: ContactsByKind, size: SceneSize, of: ContactsField): void {
  const { vertices, elements } = size;
  const edges = 3 * elements; // at most
  checkKind(contacts.vertexTriangle, size, [vertices, elements], of);
  checkKind(contacts.edgeEdge, size, [edges, edges], of);
  checkKind(contacts.triangleTriangle, size, [elements, elements], of);
  checkKind(contacts.edgeTriangle, size, [edges, elements], of);
  checkKind(contacts.vertexSolid, size, [vertices, elements], of);
}

function checkKind(contacts: Contacts, { vertices }: SceneSize, most: [number, number], of: ContactsField): void {
  const vertex = contacts.stencils.find((each) => each >= vertices);
  if (vertex !== undefined) throw dataLoss(`${of}.stencils names ${vertex}; the scene has ${vertices} vertices`);
  const id = contacts.elements.find((each, i) => each >= most[i % 2]);
  if (id !== undefined) throw dataLoss(`${of}.elements names ${id}, which the scene does not have`);
}

/** The scene has what the pairs name. */
function checkPairs(pairs: readonly PairOfMeshes[], size: SceneSize): void {
  for (const { second, deepest } of pairs) {
    if (second >= size.meshes) throw dataLoss(`pairs.meshes names ${second}; the scene has ${size.meshes} meshes`);
    if (deepest !== undefined && deepest >= size.vertices) {
      throw dataLoss(`pairs.deepest names ${deepest}; the scene has ${size.vertices} vertices`);
    }
  }
}

/** Not NaN. */
function isFraction(value: number): boolean {
  return value >= 0 && value <= 1;
}
