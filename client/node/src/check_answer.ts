// These checks guard everything that is computed from an answer: the daemon may be wrong, or another program may answer.

import type { Contacts, ContactsByKind, ContactsField } from "./contacts.js";
import { Code, CollidedError } from "./errors.js";
import type { FrameDone } from "./generated/collided/v1/frame.js";
import type { Scene, SceneSpec } from "./generated/collided/v1/scene.js";

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
export function checkTotal(done: FrameDone, { vertexTriangle, edgeEdge, triangleTriangle, edgeTriangle }: ContactsByKind): void {
  const came = vertexTriangle.count + edgeEdge.count + triangleTriangle.count + edgeTriangle.count;
  if (done.contactCount !== BigInt(came)) throw dataLoss(`done.contact_count is ${done.contactCount}, and ${came} contacts came`);
}

/** Limits came only if the frame asked for them. */
export function checkAsked({ vertexTriangle, edgeEdge }: ContactsByKind, isAsked: boolean): void {
  const came = vertexTriangle.count + edgeEdge.count;
  if (came > 0 && !isAsked) throw dataLoss(`limits has ${came} contacts, and the frame did not ask for them`);
}

/** Times and distances of contacts, and a count that no array confirms where they are bare. `of`: the field of the answer. */
export function checkNumbers(contacts: Contacts, of: ContactsField, isBare: boolean): void {
  const time = contacts.toi.find((toi) => !isFraction(toi));
  if (time !== undefined) throw dataLoss(`${of}.toi has ${time}; it must be in [0, 1]`);
  const distance = contacts.distance.find((each) => !(each >= 0));
  if (distance !== undefined) throw dataLoss(`${of}.distance has ${distance}; it must be 0 or more`);
  if (isBare && contacts.count > MOST_BARE) {
    throw dataLoss(`${of}.count is ${contacts.count} in all without any array; it must be at most ${MOST_BARE}`);
  }
}

/** The scene has what a frame's contacts and limits name. A size of 0 is not known. */
export function checkIds(output: ContactsByKind & { limits: ContactsByKind }, size: SceneSize): void {
  if (size.vertices === 0) return;
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
}

function checkKind(contacts: Contacts, { vertices }: SceneSize, most: [number, number], of: ContactsField): void {
  const vertex = contacts.stencils.find((each) => each >= vertices);
  if (vertex !== undefined) throw dataLoss(`${of}.stencils names ${vertex}; the scene has ${vertices} vertices`);
  const id = contacts.elements.find((each, i) => each >= most[i % 2]);
  if (id !== undefined) throw dataLoss(`${of}.elements names ${id}, which the scene does not have`);
}

/** Not NaN. */
function isFraction(value: number): boolean {
  return value >= 0 && value <= 1;
}
