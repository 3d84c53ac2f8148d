// This file reads which meshes touch, overlap, or are one inside the other: pairs that are not apart, one of them a solid.

import { join } from "./arrays.js";
import { dataLoss } from "./check_answer.js";
import { MeshPairState, type MeshPairs } from "./generated/collided/v1/contact.js";

/** A pair of meshes that are not apart, one of them a solid. */
export interface PairOfMeshes {
  /** Index in the scene's spec, the lower one of both. */
  first: number;
  second: number;
  /** TOUCHING, OVERLAPPING, FIRST_INSIDE or SECOND_INSIDE. */
  state: MeshPairState;
  /** Vertices of the first mesh that are inside the second. */
  firstInside: number;
  /** Vertices of the second mesh that are inside the first. */
  secondInside: number;
  /** Of these vertices the deepest, scene-wide, the least of several; undefined if there is none. */
  deepest: number | undefined;
  /** Its distance from the other mesh's surface, in the unit of the positions; 0 if there is none. */
  depth: number;
}

type Column = keyof MeshPairs;

const NO_VERTEX = 2 ** 32 - 1;
const WIDTHS: Record<Column, number> = { meshes: 8, states: 1, inside: 8, deepest: 4, depths: 8 };

/** Joins all that the messages of an answer have. Throws (DATA_LOSS) if that cannot be. */
export function pairsOf(messages: readonly MeshPairs[]): PairOfMeshes[] {
  for (const message of messages) checkLengths(message);
  const column = (name: Column) => messages.map((message) => message[name]);
  const meshes = join(Uint32Array, column("meshes"));
  const inside = join(Uint32Array, column("inside"));
  const deepest = join(Uint32Array, column("deepest"));
  const depths = join(Float64Array, column("depths"));
  const pairs = Array.from(join(Uint8Array, column("states")), (state, i) => ({
    first: meshes[2 * i],
    second: meshes[2 * i + 1],
    state,
    firstInside: inside[2 * i],
    secondInside: inside[2 * i + 1],
    deepest: deepest[i] === NO_VERTEX ? undefined : deepest[i],
    depth: depths[i],
  }));
  pairs.forEach((pair, i) => checkPair(pair, pairs[i - 1]));
  return pairs;
}

function checkLengths(message: MeshPairs): void {
  const count = message.states.length;
  for (const [name, width] of Object.entries(WIDTHS) as [Column, number][]) {
    const has = message[name].length;
    if (has !== count * width) throw dataLoss(`pairs.${name} has ${has} bytes for ${count} pairs; it needs ${count * width}`);
  }
}

function checkPair(pair: PairOfMeshes, before: PairOfMeshes | undefined): void {
  const { first, second, state, firstInside, secondInside, deepest, depth } = pair;
  const isAfter = !before || first > before.first || (first === before.first && second > before.second);
  if (first >= second || !isAfter) {
    throw dataLoss(`pairs.meshes has ${first} and ${second}; pairs must ascend, and the lower index be first`);
  }
  if (state < MeshPairState.TOUCHING || state > MeshPairState.SECOND_INSIDE) {
    throw dataLoss(`pairs.states has ${state}, which this client does not know`);
  }
  if ((firstInside + secondInside > 0) !== (deepest !== undefined)) {
    throw dataLoss(`pairs.deepest has ${deepest ?? "no vertex"} where ${firstInside} and ${secondInside} vertices are inside`);
  }
  if (!(depth >= 0 && depth < Infinity)) throw dataLoss(`pairs.depths has ${depth}; it must be 0 or more, and finite`);
}
