// What callers may pass. The protobuf encoder would drop a field that it does not know, and wrap or coerce a value of
// another type; here both are refused by name. Ranges that only the daemon knows are left to it.

import { invalid } from "./errors.js";

/** What a value must be, in words; undefined if it is that. */
export type Rule = (value: unknown) => string | undefined;

/** A rule for each field of an object. */
export type Rules<T> = { [K in keyof Required<T>]: Rule };

const LAST_UINT32 = 2 ** 32 - 1;
const MAX_SECONDS = 2_000_000;

export const uint32: Rule = (value) => {
  const isUint32 = Number.isInteger(value) && (value as number) >= 0 && (value as number) <= LAST_UINT32;
  return isUint32 ? undefined : `an integer from 0 to ${LAST_UINT32}`;
};
export const finite: Rule = (value) => (Number.isFinite(value) ? undefined : "a finite number");
/** A timer of Node's takes no more. */
export const seconds: Rule = (value) => {
  const isTime = Number.isFinite(value) && (value as number) >= 0 && (value as number) <= MAX_SECONDS;
  return isTime ? undefined : `seconds from 0 to ${MAX_SECONDS}`;
};
export const boolean: Rule = (value) => (typeof value === "boolean" ? undefined : "true or false");
/** UTF-8 has no half of a pair of surrogates. */
export const string: Rule = (value) =>
  typeof value === "string" && !/\p{Surrogate}/u.test(value) ? undefined : "a string of whole characters";
export const list: Rule = (value) => (Array.isArray(value) ? undefined : "an array");
/** Checked where it is used. */
export const anything: Rule = () => undefined;

/** 64 bits, unsigned: a bigint, or a number that has not lost digits. */
export const uint64: Rule = (value) => {
  const isExact = typeof value === "bigint" || Number.isSafeInteger(value);
  const inRange = isExact && BigInt(value as bigint) >= 0n && BigInt(value as bigint) < 2n ** 64n;
  return inRange ? undefined : "a bigint from 0 to 2^64 - 1, or an integer number up to 2^53 - 1";
};

/** A value of an enum of the protocol, which is named as in `oneOf({ DetectionMode })`: messages spell values as code does. */
export function oneOf(enums: Record<string, Record<string, string | number>>): Rule {
  const [[type, values]] = Object.entries(enums);
  const known = Object.entries(values).filter(([, value]) => typeof value === "number" && value >= 0);
  const usable = known.filter(([, value]) => value !== 0).map(([name, value]) => `${type}.${name} (${value})`);
  return (value) => (known.some(([, number]) => number === value) ? undefined : `one of ${usable.join(", ")}`);
}

/** An array, each of whose entries follows the rule. */
export function listOf(rule: Rule): Rule {
  return (value) => {
    if (!Array.isArray(value)) return "an array";
    const bad = value.findIndex((entry) => rule(entry) !== undefined);
    return bad < 0 ? undefined : `an array, and [${bad}], ${show(value[bad])}, ${rule(value[bad])}`;
  };
}

/** Throws unless `value` is an object whose fields are all known and follow their rules. Absent ones do. */
export function check<T extends object>(value: T, rules: Rules<T>, path: string): void {
  if (typeof value !== "object" || value === null) throw invalid(path, `is ${show(value)}; it must be an object`);
  for (const [name, field] of Object.entries(value)) {
    if (!Object.hasOwn(rules, name)) throw invalid(join(path, name), `is not known; ${path} has ${namesOf(rules)}`);
    const must = field === undefined ? undefined : rules[name as keyof T](field);
    if (must !== undefined) throw invalid(join(path, name), `is ${show(field)}; it must be ${must}`);
  }
}

function namesOf(rules: object): string {
  return Object.keys(rules).map(protocolName).join(", ");
}

/** The same for a single value, which must be there. */
export function checkValue(value: unknown, rule: Rule, path: string): void {
  const must = rule(value);
  if (must !== undefined) throw invalid(path, `is ${show(value)}; it must be ${must}`);
}

/** The path of a field as the protocol names it: "spec.meshes[0]" and "vertexCount" to "spec.meshes[0].vertex_count". */
export function join(path: string, name: string): string {
  return `${path}.${protocolName(name)}`;
}

function protocolName(name: string): string {
  return name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
}

/** A value as a message shows it, in few characters. */
export function show(value: unknown): string {
  if (ArrayBuffer.isView(value)) return `a ${value.constructor.name}`;
  if (Array.isArray(value)) return `an array of ${value.length}`;
  if (typeof value === "object" && value !== null) return "an object";
  const text = typeof value === "string" ? JSON.stringify(value) : String(value);
  return text.length > 60 ? `${text.slice(0, 60)}...` : text;
}
