// Between JavaScript's arrays and the protocol's packed little-endian bytes.

import { endianness } from "node:os";
import { checkValue, show, uint32 } from "./check.js";
import { Code, CollidedError, invalid } from "./errors.js";
import { PositionFormat } from "./generated/collided/v1/scene.js";

/** Positions as a scene's format has them: Float32Array (F32), Float64Array (F64) or Uint16Array (Q16); x y z of each vertex. */
export type Positions = Float32Array | Float64Array | Uint16Array;
/** Indices, numbered from 0. */
export type Indices = Uint32Array | readonly number[];
/** The rows of [R | t], 12 numbers, which move p to R p + t. */
export type RigidMatrix = Float64Array | readonly number[];

if (endianness() !== "LE") {
  throw new CollidedError(Code.UNIMPLEMENTED, "this machine is big-endian; the protocol's arrays are little-endian");
}

/** The memory of a typed array, not copied. */
export function bytesOf(array: ArrayBufferView): Uint8Array {
  return new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
}

/** `Type` of the given byte chunks, one after the other. Copied: a message's bytes begin anywhere, a typed array cannot. */
export function join<T extends ArrayBufferView>(Type: new (buffer: ArrayBuffer) => T, chunks: Uint8Array[]): T {
  const bytes = new Uint8Array(chunks.reduce((sum, chunk) => sum + chunk.length, 0));
  let at = 0;
  for (const chunk of chunks) {
    bytes.set(chunk, at);
    at += chunk.length;
  }
  return new Type(bytes.buffer);
}

/** Indices as bytes. `width`: how many make an entry, such as 3 for triangles. */
export function packIndices(indices: Indices | undefined, width: number, field: string): Uint8Array {
  if (indices === undefined) return new Uint8Array();
  if (!(indices instanceof Uint32Array) && !Array.isArray(indices)) {
    throw invalid(field, `is ${show(indices)}; it must be a Uint32Array or an array of integers`);
  }
  if (indices.length % width !== 0) throw invalid(field, `has ${indices.length} indices, which is no multiple of ${width}`);
  return bytesOf(indices instanceof Uint32Array ? indices : uint32Array(indices, field));
}

/** Uint32Array.from would wrap -1 and turn 0.5 into 0. */
function uint32Array(numbers: readonly number[], field: string): Uint32Array {
  const bad = numbers.findIndex((number) => uint32(number) !== undefined);
  if (bad >= 0) checkValue(numbers[bad], uint32, `${field}[${bad}]`);
  return Uint32Array.from(numbers);
}

const ARRAYS = {
  [PositionFormat.UNSPECIFIED]: Float32Array,
  [PositionFormat.F32]: Float32Array,
  [PositionFormat.F64]: Float64Array,
  [PositionFormat.Q16]: Uint16Array,
} as const;

/** The bytes of a vertex's position where the daemon shows it: F64 as such, all other formats as F32. */
export function shownBytes(format: PositionFormat): number {
  return 3 * (format === PositionFormat.F64 ? Float64Array : Float32Array).BYTES_PER_ELEMENT;
}

/** Positions that the daemon shows of a scene with positions of `format`. */
export function unpackShown(bytes: Uint8Array, format: PositionFormat): Float32Array | Float64Array {
  return format === PositionFormat.F64 ? join(Float64Array, [bytes]) : join(Float32Array, [bytes]);
}

/** Positions as bytes. An array of another type is refused: to round it or not is for the caller to say. */
export function packPositions(positions: Positions | undefined, format: PositionFormat, field: string): Uint8Array {
  if (positions === undefined) return new Uint8Array();
  const Type = ARRAYS[format];
  if (positions instanceof Type) return bytesOf(positions);
  throw invalid(field, `is ${show(positions)}; position_format ${PositionFormat[format]} needs a ${Type.name}`);
}

/** A transform as bytes. */
export function packMatrix(matrix: RigidMatrix | undefined, field: string): Uint8Array {
  return matrix === undefined ? new Uint8Array() : bytesOf(matrixOf(matrix, field));
}

/** A transform with its 12 numbers. */
export function matrixOf(matrix: RigidMatrix, field: string): Float64Array {
  const isMatrix = (matrix instanceof Float64Array || Array.isArray(matrix)) && matrix.length === 12;
  if (!isMatrix || !Array.from(matrix).every(Number.isFinite)) {
    throw invalid(field, `is ${show(matrix)}; it must be 12 finite numbers, the rows of [R | t]`);
  }
  return Float64Array.from(matrix);
}
