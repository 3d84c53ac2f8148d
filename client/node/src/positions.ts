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
  const isBad = (a: number) => !(a >= 0 && a <= 1);
  if (typeof fraction === "number") {
    if (isBad(fraction)) throw invalid("fraction", `is ${fraction}; it must be from 0 to 1`);
    return;
  }
  if (!(fraction instanceof Float64Array) || fraction.length !== count) {
    const has = `${show(fraction)} of ${(fraction as Float64Array | undefined)?.length}`;
    throw invalid("fraction", `is ${has}; it must be a number, or a Float64Array of ${count}`);
  }
  const bad = fraction.findIndex(isBad);
  if (bad >= 0) throw invalid(`fraction[${bad}]`, `is ${fraction[bad]}; it must be from 0 to 1`);
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
