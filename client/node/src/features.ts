// Finds what an older daemon does not know: it would ignore a field, and answer another question.

import { BinaryReader, WireType } from "@bufbuild/protobuf/wire";
import { Code, CollidedError } from "./errors.js";
import { CollisionServiceDefinition, type GetServerInfoResponse } from "./generated/collided/v1/collision_service.js";
import { ADDITIONS, type Field, MESSAGES, REQUESTS } from "./generated/requests.js";

/** Holds what the protocol has gained since release 0.1.0 (added_in.proto) and a daemon lacks; usually that is nothing. */
export class Features {
  readonly #daemon: string;
  readonly #missing = new Map(Object.entries(ADDITIONS)); // full names, with the release that brought each

  constructor(info: GetServerInfoResponse, address: string) {
    this.#daemon = `the daemon at ${address} is ${info.version || "of an unknown version"}`;
    for (const known of info.features) this.#missing.delete(known);
  }

  /**
   * Throws UNIMPLEMENTED, naming field, release and daemon, if the daemon lacks a method or would ignore something of its
   * encoded request. Requests are read only if the daemon lacks anything.
   */
  check(method: string, request: Uint8Array): void {
    if (this.#missing.size === 0) return;
    this.#require(`${CollisionServiceDefinition.fullName}.${method}`, method);
    for (const [name, what] of contents(REQUESTS[method], request, "")) this.#require(name, what);
  }

  #require(name: string, what: string): void {
    const release = this.#missing.get(name);
    if (release === undefined) return;
    const text = `${what} needs a daemon of release ${release} or later; ${this.#daemon}`;
    throw new CollidedError(Code.UNIMPLEMENTED, text, { field: what });
  }
}

/** Yields the full names and the paths of the fields and enum values that an encoded message has, at all levels. */
function* contents(type: string, message: Uint8Array, path: string): Generator<[name: string, what: string]> {
  const reader = new BinaryReader(message);
  const places = new Places(path);
  while (reader.pos < reader.len) {
    const [number, wireType] = reader.tag();
    const field = MESSAGES[type][number];
    yield [`${type}.${field.name}`, places.of(field)];
    if (field.message !== undefined) {
      yield* contents(field.message, reader.bytes(), places.ofNext(field));
    } else if (field.values !== undefined) {
      for (const value of numbers(reader, wireType)) {
        const place = places.ofNext(field);
        const name = field.values[value];
        if (name !== undefined) yield [name, `${place} = ${name.slice(name.lastIndexOf(".") + 1)}`];
      }
    } else {
      reader.skip(wireType, number);
    }
  }
}

/** Gives the paths of a message's fields. It counts the entries of repeated fields, as the encoding has no indices. */
class Places {
  readonly #path: string;
  readonly #entries = new Map<Field, number>();

  constructor(path: string) {
    this.#path = path;
  }

  of(field: Field): string {
    return this.#path === "" ? field.name : `${this.#path}.${field.name}`;
  }

  ofNext(field: Field): string {
    if (!field.isRepeated) return this.of(field);
    const entry = this.#entries.get(field) ?? 0;
    this.#entries.set(field, entry + 1);
    return `${this.of(field)}[${entry}]`;
  }
}

/** Reads the value of an enum field, or the values of a repeated one, which are packed. */
function* numbers(reader: BinaryReader, wireType: WireType): Generator<number> {
  if (wireType === WireType.LengthDelimited) {
    const end = reader.uint32() + reader.pos;
    while (reader.pos < end) yield reader.int32();
  } else {
    yield reader.int32();
  }
}
