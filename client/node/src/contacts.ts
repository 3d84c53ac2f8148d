// A frame's contacts as typed arrays, assembled from the daemon's chunks.

import { join } from "./arrays.js";
import { join as pathOf } from "./check.js";
import { checkNumbers, dataLoss } from "./check_answer.js";
import { type ContactChunk, ContactKind } from "./generated/collided/v1/contact.js";

/** One contact, with its entries of the arrays of Contacts. A field is undefined if its array is empty. */
export interface Contact {
  elements: [number, number] | undefined;
  stencil: [number, number, number, number] | undefined;
  toi: number | undefined;
  distance: number | undefined;
  weights: [number, number] | undefined;
  normal: [number, number, number] | undefined;
  flags: number | undefined;
  features: number | undefined;
  signedDistance: number | undefined;
}

/**
 * Contacts of one kind in canonical order, as flat arrays. An array is empty if it was not requested or not computed.
 * `for (const { elements, toi } of contacts)` visits them one by one, which is slower.
 */
export interface Contacts extends Iterable<Contact> {
  /** How many there are. */
  readonly count: number;
  /** The same as `count`. */
  readonly length: number;
  /** Two ids for each contact: vertex and element, two edges, two triangles, edge and triangle, or vertex and triangle of a solid; scene-wide. */
  elements: Uint32Array;
  /** Four vertices for each contact; scene-wide. */
  stencils: Uint32Array;
  /** Time of impact for each contact, in [0, 1] of the step. */
  toi: Float64Array;
  /** For each contact, >= 0, in the unit of the positions; of vertices in solids it is minus the depth, < 0. */
  distance: Float64Array;
  /** Two for each contact: `contactPoints` turns them into points. */
  weights: Float64Array;
  /** x y z for each contact, of unit length, from the second feature to the first. */
  normals: Float32Array;
  /** A byte of masks for each contact: `flags[i] & ContactFlag.INITIAL`. */
  flags: Uint8Array;
  /**
   * A byte for each contact of a discrete frame. `placeOnTriangle` and `placesOnEdges` read on which features the closest points
   * are; masks say what covers it: `features[i] & ClosestFeature.NEARER_AT_SECOND`.
   */
  features: Uint8Array;
  /**
   * The distance of each contact with a sign, in discrete frames of scenes with a solid. It is negative where the closest point of one
   * feature is inside the other feature's mesh, a solid. It is NaN where neither mesh is a solid, of a mesh and itself, and where one of
   * the two features, at a distance above 0, meets the other's mesh.
   */
  signedDistances: Float64Array;
}

/** Contacts of all kinds. */
export interface ContactsByKind {
  vertexTriangle: Contacts;
  edgeEdge: Contacts;
  triangleTriangle: Contacts;
  edgeTriangle: Contacts;
  vertexSolid: Contacts;
}

/** The fields of an answer that have contacts, as errors name them. */
export type ContactsField = "contacts" | "limits";

type Field = Exclude<keyof Contacts, "count" | "length" | typeof Symbol.iterator>;

const ENTRIES: Record<Field, number> = {
  elements: 2,
  stencils: 4,
  toi: 1,
  distance: 1,
  weights: 2,
  normals: 3,
  flags: 1,
  features: 1,
  signedDistances: 1,
};
const FIELDS = Object.keys(ENTRIES) as Field[];
/** Contacts that limit a way have the others. */
const OF_DISCRETE_FRAMES: readonly Field[] = ["features", "signedDistances"];

/**
 * Joins chunks of a field of the answer, `of`. Throws (DATA_LOSS) if an array's length is not what its chunk's count asks for, or
 * a kind is not known.
 */
export function contactsOf(chunks: readonly ContactChunk[], of: ContactsField = "contacts"): ContactsByKind {
  const { VERTEX_TRIANGLE, EDGE_EDGE, TRIANGLE_TRIANGLE, EDGE_TRIANGLE, VERTEX_SOLID } = ContactKind;
  const known = [VERTEX_TRIANGLE, EDGE_EDGE, TRIANGLE_TRIANGLE, EDGE_TRIANGLE, VERTEX_SOLID];
  if (chunks.some((chunk) => chunk.count === 0)) throw dataLoss(`${of}.count is 0; a chunk has 1 contact or more`);
  if (chunks.some((chunk) => chunk.shared)) throw dataLoss(`${of}.shared names shared memory, and there is none over gRPC`);
  const stranger = chunks.find((chunk) => !known.includes(chunk.kind));
  if (stranger) throw dataLoss(`${of}.kind is ${stranger.kind}, which this client does not know`);
  const ofKind = (kind: ContactKind) =>
    assemble(
      chunks.filter((chunk) => chunk.kind === kind),
      kind,
      of,
    );
  return {
    vertexTriangle: ofKind(VERTEX_TRIANGLE),
    edgeEdge: ofKind(EDGE_EDGE),
    triangleTriangle: ofKind(TRIANGLE_TRIANGLE),
    edgeTriangle: ofKind(EDGE_TRIANGLE),
    vertexSolid: ofKind(VERTEX_SOLID),
  };
}

/** Joins chunks of contacts that limit a way. Throws (DATA_LOSS) if one of their arrays is missing, or a kind limits no way. */
export function limitsOf(chunks: readonly ContactChunk[]): ContactsByKind {
  const limits = contactsOf(chunks, "limits");
  for (const kind of [ContactKind.TRIANGLE_TRIANGLE, ContactKind.EDGE_TRIANGLE, ContactKind.VERTEX_SOLID]) {
    if (chunks.some((chunk) => chunk.kind === kind)) {
      throw dataLoss(`limits.kind is ${ContactKind[kind]}; only a vertex and a triangle, or two edges, limit a way`);
    }
  }
  for (const contacts of [limits.vertexTriangle, limits.edgeEdge]) {
    const isMissing = (field: Field) => contacts[field].length !== contacts.count * ENTRIES[field];
    const missing = FIELDS.find((field) => !OF_DISCRETE_FRAMES.includes(field) && isMissing(field));
    if (missing) throw dataLoss(`limits.${missing} has ${contacts[missing].length} entries for ${contacts.count} contacts`);
  }
  return limits;
}

function assemble(chunks: ContactChunk[], kind: ContactKind, of: ContactsField): Contacts {
  const count = chunks.reduce((sum, chunk) => sum + chunk.count, 0);
  const array = <T extends ArrayBufferView & { length: number }>(Type: new (buffer: ArrayBuffer) => T, field: Field): T => {
    const joined = join(Type, whole(chunks, field, Type as unknown as { BYTES_PER_ELEMENT: number }, of));
    if (joined.length > 0 && joined.length !== count * ENTRIES[field]) {
      throw dataLoss(`${pathOf(of, field)} has ${joined.length} entries for ${count} contacts`);
    }
    return joined;
  };
  const contacts = new ContactArrays(count, {
    elements: array(Uint32Array, "elements"),
    stencils: array(Uint32Array, "stencils"),
    toi: array(Float64Array, "toi"),
    distance: array(Float64Array, "distance"),
    weights: array(Float64Array, "weights"),
    normals: array(Float32Array, "normals"),
    flags: array(Uint8Array, "flags"),
    features: array(Uint8Array, "features"),
    signedDistances: array(Float64Array, "signedDistances"),
  });
  checkNumbers(contacts, kind, of, FIELDS.every((field) => contacts[field].length === 0));
  return contacts;
}

class ContactArrays implements Contacts {
  readonly elements: Uint32Array;
  readonly stencils: Uint32Array;
  readonly toi: Float64Array;
  readonly distance: Float64Array;
  readonly weights: Float64Array;
  readonly normals: Float32Array;
  readonly flags: Uint8Array;
  readonly features: Uint8Array;
  readonly signedDistances: Float64Array;

  constructor(
    readonly count: number,
    arrays: Pick<Contacts, Field>,
  ) {
    ({
      elements: this.elements,
      stencils: this.stencils,
      toi: this.toi,
      distance: this.distance,
      weights: this.weights,
      normals: this.normals,
      flags: this.flags,
      features: this.features,
      signedDistances: this.signedDistances,
    } = arrays);
  }

  get length(): number {
    return this.count;
  }

  *[Symbol.iterator](): Iterator<Contact> {
    for (let i = 0; i < this.count; ++i) {
      yield {
        elements: this.#entries("elements", i),
        stencil: this.#entries("stencils", i),
        toi: this.toi[i],
        distance: this.distance[i],
        weights: this.#entries("weights", i),
        normal: this.#entries("normals", i),
        flags: this.flags[i],
        features: this.features[i],
        signedDistance: this.signedDistances[i],
      };
    }
  }

  #entries<T extends number[]>(field: Field, i: number): T | undefined {
    const all = this[field];
    return all.length === 0 ? undefined : ([...all.subarray(i * ENTRIES[field], (i + 1) * ENTRIES[field])] as T);
  }
}

function whole(
  chunks: ContactChunk[],
  field: Field,
  { BYTES_PER_ELEMENT }: { BYTES_PER_ELEMENT: number },
  of: ContactsField,
): Uint8Array[] {
  for (const chunk of chunks) {
    const needed = chunk.count * ENTRIES[field] * BYTES_PER_ELEMENT;
    if (chunk[field].length !== 0 && chunk[field].length !== needed) {
      throw dataLoss(`${pathOf(of, field)} has ${chunk[field].length} bytes for ${chunk.count} contacts; it needs ${needed}`);
    }
  }
  return chunks.map((chunk) => chunk[field]);
}
