// Where contacts lie, by the formulas of proto/CONVENTIONS.md.

import type { Contacts } from "./contacts.js";
import { invalid } from "./errors.js";
import { ContactKind } from "./generated/collided/v1/contact.js";

/** What the second feature of a vertex-triangle contact is. */
export type ElementKind = "triangle" | "edge" | "point";

/** The closest points of the two features of each contact: x y z each. */
export interface ContactPoints {
  first: Float64Array;
  second: Float64Array;
}

type WithPoints = Pick<Contacts, "count" | "stencils" | "weights" | "toi">;

/** Of vertex-triangle contact i. A loose edge a b has the stencil v a b b, a loose point a has v a a a. */
export function elementKind(contacts: Pick<Contacts, "stencils">, i: number): ElementKind {
  const [a, b, c] = contacts.stencils.subarray(4 * i + 1, 4 * i + 4);
  if (a === undefined) throw invalid("i", `is ${i}; there are ${contacts.stencils.length / 4} stencils`);
  if (b !== c) return "triangle";
  return a === b ? "point" : "edge";
}

/**
 * The closest points of each contact at its time of impact (CCD) or in the frame (DCD: without `start`). `start` and `end`
 * are the positions of all vertices of the scene at t = 0 and t = 1, x y z each. The contacts need stencils and weights
 * (ContactField.WEIGHTS) and, with `start`, toi.
 */
export function contactPoints(
  kind: ContactKind.VERTEX_TRIANGLE | ContactKind.EDGE_EDGE | ContactKind.VERTEX_SOLID,
  contacts: WithPoints,
  end: ArrayLike<number>,
  start?: ArrayLike<number>,
): ContactPoints {
  checkArrays(contacts, end, start);
  const first = new Float64Array(3 * contacts.count);
  const second = new Float64Array(3 * contacts.count);
  for (let i = 0; i < contacts.count; ++i) {
    const [w0, w1] = contacts.weights.subarray(2 * i, 2 * i + 2);
    const t = contacts.toi[i];
    for (let axis = 0; axis < 3; ++axis) {
      const x = (k: number) => {
        const at = 3 * contacts.stencils[4 * i + k] + axis;
        return start ? (1 - t) * start[at] + t * end[at] : end[at];
      };
      const isVertex = kind !== ContactKind.EDGE_EDGE;
      first[3 * i + axis] = isVertex ? x(0) : (1 - w0) * x(0) + w0 * x(1);
      second[3 * i + axis] = isVertex ? (1 - w0 - w1) * x(1) + w0 * x(2) + w1 * x(3) : (1 - w1) * x(2) + w1 * x(3);
    }
  }
  return { first, second };
}

function checkArrays(contacts: WithPoints, end: ArrayLike<number>, start?: ArrayLike<number>): void {
  for (const [name, entries] of [["stencils", 4], ["weights", 2], ...(start ? ([["toi", 1]] as const) : [])] as const) {
    const has = contacts[name].length;
    if (has !== entries * contacts.count) {
      throw invalid(`contacts.${name}`, `has ${has} entries for ${contacts.count} contacts; ask for the field`);
    }
  }
  if (start && start.length !== end.length) throw invalid("start", `has ${start.length} coordinates, end has ${end.length}`);
  const last = contacts.stencils.reduce((max, vertex) => Math.max(max, vertex), 0);
  if (contacts.count > 0 && 3 * last + 2 >= end.length) {
    throw invalid("end", `has ${end.length} coordinates; vertex ${last} needs ${3 * last + 3}: those of the whole scene`);
  }
}
