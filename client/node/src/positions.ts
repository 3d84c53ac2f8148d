// Positions where the daemon has them, to the last bit, and as Q16. JavaScript computes in binary64 and fuses nothing, as
// the formulas of client/STEPPING.md and proto/CONVENTIONS.md ask for.

import { type RigidMatrix, matrixOf } from "./arrays.js";
import { checkValue, finite, listOf, show } from "./check.js";
import { invalid } from "./errors.js";
import type { QuantizationBox } from "./generated/collided/v1/scene.js";

/** Positions that a simulator computes with; Q16 is for the wire alone. */
export type RealPositions = Float32Array | Float64Array;

/**
 * Moves coordinates in place the fraction of the way to `target` that the daemon moved them: `done.advanced`, or a frame's
 * fromLastFraction; or each vertex by a fraction of its own, as fractionsOf has them. Storing into a Float32Array rounds, as the
 * daemon does.
 */
export function moveAlong<T extends RealPositions>(positions: T, target: T, fraction: number | Float64Array): void {
  checkReal(positions, "positions");
  if (target?.constructor !== positions.constructor || target.length !== positions.length) {
    const has = `${show(target)} of ${target?.length}`;
    throw invalid("target", `is ${has}; positions are ${show(positions)} of ${positions.length}`);
  }
  checkFractions(fraction, positions.length / 3);
  for (let i = 0; i < positions.length; ++i) {
    const a = typeof fraction === "number" ? fraction : fraction[Math.floor(i / 3)];
    if (a === 1) positions[i] = target[i];
    else if (a !== 0) positions[i] = positions[i] + a * (target[i] - positions[i]);
  }
}

function checkFractions(fraction: number | Float64Array, count: number): void {
  if (typeof fraction === "number") return checkFraction(fraction);
  if (!(fraction instanceof Float64Array) || fraction.length !== count) {
    const has = `${show(fraction)} of ${(fraction as Float64Array | undefined)?.length}`;
    throw invalid("fraction", `is ${has}; it must be a number, or a Float64Array of ${count}`);
  }
  fraction.forEach((each, i) => checkFraction(each, `fraction[${i}]`));
}

function checkFraction(fraction: number, name = "fraction"): void {
  const isFraction = typeof fraction === "number" && fraction >= 0 && fraction <= 1;
  if (!isFraction) throw invalid(name, `is ${show(fraction)}; it must be from 0 to 1`);
}

/** Moves the first positions of a rigid mesh in place to where the pose `matrix` has them. */
export function moveRigidly(positions: RealPositions, matrix: RigidMatrix): void {
  checkReal(positions, "positions");
  const m = matrixOf(matrix, "matrix");
  for (let i = 0; i < positions.length; i += 3) {
    const x = positions[i];
    const y = positions[i + 1];
    const z = positions[i + 2];
    for (let row = 0; row < 3; ++row) {
      const r = 4 * row;
      positions[i + row] = m[r] * x + m[r + 1] * y + m[r + 2] * z + m[r + 3];
    }
  }
}

/**
 * Returns the pose of a rigid mesh, 12 numbers, at a fraction of the way from the pose `start` to `target`, where an advance ends:
 * fractionsOf has the fraction, which is the mesh's own or the least of its vertices. The daemon takes turns of up to 3 radians.
 * Throws for a fraction that is not from 0 to 1. Between these it also throws for rotations that are half a turn apart.
 */
export function poseAlong(start: RigidMatrix, target: RigidMatrix, fraction: number): Float64Array {
  const from = matrixOf(start, "start");
  const to = matrixOf(target, "target");
  checkFraction(fraction);
  if (fraction === 0) return from;
  if (fraction === 1) return to;
  // The names of proto/CONVENTIONS.md.
  const f = fraction;
  const { c, v } = halfTurn(from, to);
  const turn = (along: number, across: number, turned: number, x: Vector): Vector =>
    plus(times(along, x), plus(times(across * dot(v, x), v), times(turned, cross(v, x))));
  const q = dot(v, v);
  const m = 2 * f - 1;
  const h = (2 * (f * (1 - f))) / (c + Math.sqrt(Math.max(0, 1 - m * m * q)));
  const s = f * c + h * q;
  const r = f - h * c;
  const columns = [0, 1, 2].map((k) => {
    const a = column(from, k);
    const back = turn(1 - 2 * q, 2, -2 * c, column(to, k));
    return turn(1 - 2 * (r * q), 2 * r, 2 * s, plus(a, times(f, minus(back, a))));
  });
  const t = column(from, 3);
  const way = minus(column(to, 3), t);
  columns.push(plus(t, plus(times(f, way), times(h, cross(way, v)))));
  return Float64Array.from({ length: 12 }, (_, i) => columns[i % 4][Math.floor(i / 4)]);
}

type Vector = [number, number, number];

/** The rotation from one pose to another as a unit quaternion. */
function halfTurn(from: Float64Array, to: Float64Array): { c: number; v: Vector } {
  let cosine = 1;
  let sine: Vector = [0, 0, 0];
  for (let k = 0; k < 3; ++k) {
    const a = column(from, k);
    const b = column(to, k);
    cosine += dot(a, b);
    sine = plus(sine, cross(a, minus(b, a)));
  }
  if (!(cosine > 0 && cosine < Infinity)) {
    throw invalid("target", "has a rotation that is half a turn from that of start; they must turn by less");
  }
  const length = Math.sqrt(cosine * cosine + dot(sine, sine));
  return { c: cosine / length, v: times(1 / length, sine) };
}

/** One of [R | t], 0 to 3. */
const column = (m: Float64Array, k: number): Vector => [m[k], m[4 + k], m[8 + k]];
const plus = (a: Vector, b: Vector): Vector => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (s: number, a: Vector): Vector => [s * a[0], s * a[1], s * a[2]];
const dot = (a: Vector, b: Vector) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/**
 * Positions as Q16, each coordinate to the nearest step of the box. Throws for a box without three finite coordinates
 * each, in order, and for a position that is not in it: what is clamped is not where it was.
 */
export function packQuantized(positions: ArrayLike<number>, box: Partial<QuantizationBox>): Uint16Array {
  const axes = [0, 1, 2].map((axis) => axisOf(box, axis));
  if (positions.length % 3 !== 0) throw invalid("positions", `has ${positions.length} coordinates, which is no multiple of 3`);
  return Uint16Array.from(positions, (x, i) => {
    const { lower, upper, step } = axes[i % 3];
    if (!(x >= lower && x <= upper)) {
      throw invalid(`positions[${i}]`, `is ${x}, outside the box, ${lower} to ${upper}`);
    }
    return step > 0 ? Math.min(roundHalfUp((x - lower) / step), LAST) : 0;
  });
}

/** Where the daemon has positions that are encoded as Q16. */
export function unpackQuantized(encoded: Uint16Array, box: Partial<QuantizationBox>): Float32Array {
  const axes = [0, 1, 2].map((axis) => axisOf(box, axis));
  return Float32Array.from(encoded, (q, i) => axes[i % 3].lower + q * axes[i % 3].step);
}

interface Axis {
  lower: number;
  upper: number;
  step: number;
}

const LAST = 65535;

function axisOf(box: Partial<QuantizationBox>, axis: number): Axis {
  const corner = (name: "lower" | "upper") => {
    checkValue(box?.[name], listOf(finite), `box.${name}`);
    if (box[name]?.length !== 3) throw invalid(`box.${name}`, `has ${box[name]?.length} coordinates; it needs 3`);
    return box[name][axis];
  };
  const lower = corner("lower");
  const upper = corner("upper");
  if (lower > upper) throw invalid("box", `is from ${lower} to ${upper}; lower must not be more than upper`);
  return { lower, upper, step: (upper - lower) / LAST };
}

/** Of a number >= 0. Adding a half first would round 0.49999999999999994 up. */
function roundHalfUp(x: number): number {
  const whole = Math.floor(x);
  return x - whole >= 0.5 ? whole + 1 : whole;
}

function checkReal(positions: RealPositions, name: string): void {
  if (!(positions instanceof Float32Array || positions instanceof Float64Array) || positions.length % 3 !== 0) {
    throw invalid(name, `is ${show(positions)} of ${positions?.length}; it must be a Float32Array or Float64Array, x y z each`);
  }
}
