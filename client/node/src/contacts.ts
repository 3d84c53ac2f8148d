// A frame's contacts as typed arrays, assembled from the daemon's chunks.

import { join } from "./arrays.js";
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
  /** Two ids for each contact: vertex and element, two edges, two triangles, or edge and triangle; scene-wide. */
  elements: Uint32Array;
  /** Four vertices for each contact; scene-wide. */
  stencils: Uint32Array;
  /** Time of impact for each contact, in [0, 1] of the step. */
  toi: Float64Array;
  /** For each contact, >= 0, in the unit of the positions. */
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
}

/** Contacts of all kinds. */
export interface ContactsByKind {
  vertexTriangle: Contacts;
  edgeEdge: Contacts;
  triangleTriangle: Contacts;
  edgeTriangle: Contacts;
}

/** The fields of an answer that have contacts, as errors name them. */
export type ContactsField = "contacts" | "limits";

type Field = Exclude<keyof Contacts, "count" | "length" | typeof Symbol.iterator>;

const ENTRIES: Record<Field, number> = { elements: 2, stencils: 4, toi: 1, distance: 1, weights: 2, normals: 3, flags: 1, features: 1 };
const FIELDS = Object.keys(ENTRIES) as Field[];

/**
 * Joins chunks of a field of the answer, `of`. Throws (DATA_LOSS) if an array's length is not what its chunk's count asks for, or
 * a kind is not known.
 */
export function contactsOf(chunks: readonly ContactChunk[], of: ContactsField = "contacts"): ContactsByKind {
  const known = [ContactKind.VERTEX_TRIANGLE, ContactKind.EDGE_EDGE, ContactKind.TRIANGLE_TRIANGLE, ContactKind.EDGE_TRIANGLE];
  if (chunks.some((chunk) => chunk.count === 0)) throw dataLoss(`${of}.count is 0; a chunk has 1 contact or more`);
  if (chunks.some((chunk) => chunk.shared)) throw dataLoss(`${of}.shared names shared memory, and there is none over gRPC`);
  const stranger = chunks.find((chunk) => !known.includes(chunk.kind));
  if (stranger) throw dataLoss(`${of}.kind is ${stranger.kind}, which this client does not know`);
  const ofKind = (kind: ContactKind) =>
    assemble(
      chunks.filter((chunk) => chunk.kind === kind),
      of,
    );
  return {
    vertexTriangle: ofKind(ContactKind.VERTEX_TRIANGLE),
    edgeEdge: ofKind(ContactKind.EDGE_EDGE),
    triangleTriangle: ofKind(ContactKind.TRIANGLE_TRIANGLE),
    edgeTriangle: ofKind(ContactKind.EDGE_TRIANGLE),
  };
}

/** Joins chunks of contacts that limit a way. Throws (DATA_LOSS) if an array but `features` is missing, or a kind limits no way. */
export function limitsOf(chunks: readonly ContactChunk[]): ContactsByKind {
  const limits = contactsOf(chunks, "limits");
  for (const kind of [ContactKind.TRIANGLE_TRIANGLE, ContactKind.EDGE_TRIANGLE]) {
    if (chunks.some((chunk) => chunk.kind === kind)) {
      throw dataLoss(`limits.kind is ${ContactKind[kind]}; only a vertex and a triangle, or two edges, limit a way`);
    }
  }
  for (const contacts of [limits.vertexTriangle, limits.edgeEdge]) {
    const missing = FIELDS.find((field) => field !== "features" && contacts[field].length !== contacts.count * ENTRIES[field]);
    if (missing) throw dataLoss(`limits.${missing} has ${contacts[missing].length} entries for ${contacts.count} contacts`);
  }
  return limits;
}

function assemble(chunks: ContactChunk[], of: ContactsField): Contacts {
  const count = chunks.reduce((sum, chunk) => sum + chunk.count, 0);
  const array = <T extends ArrayBufferView & { length: number }>(Type: new (buffer: ArrayBuffer) => T, field: Field): T => {
    const joined = join(Type, whole(chunks, field, Type as unknown as { BYTES_PER_ELEMENT: number }, of));
    if (joined.length > 0 && joined.length !== count * ENTRIES[field]) {
      throw dataLoss(`${of}.${field} has ${joined.length} entries for ${count} contacts`);
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
  });
  checkNumbers(contacts, of, FIELDS.every((field) => contacts[field].length === 0));
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
      throw dataLoss(`${of}.${field} has ${chunk[field].length} bytes for ${chunk.count} contacts; it needs ${needed}`);
    }
  }
  return chunks.map((chunk) => chunk[field]);
}
