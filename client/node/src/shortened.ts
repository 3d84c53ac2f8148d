// This file reads how far each mesh, or vertex, went in a frame that advances.

import { join } from "./arrays.js";
import { checkValue, uint32 } from "./check.js";
import { type SceneSize, dataLoss } from "./check_answer.js";
import { AdvanceMode, type ShortenedWays } from "./generated/collided/v1/frame.js";

/** Lists what did not go all of its way in a frame that advances per mesh or per vertex. All else that moves went all of it. */
export interface Shortened {
  /** They ascend strictly. They are of meshes, or of vertices, numbered within the scene. */
  ids: Uint32Array;
  /** They tell how far each went, in [0, 1). */
  fractions: Float64Array;
}

/** Returns how far each of `count` vertices, or meshes, went, from the id `first` on, in [0, 1]. moveAlong takes these fractions. */
export function fractionsOf({ ids, fractions }: Shortened, first: number, count: number): Float64Array {
  checkValue(first, uint32, "first");
  checkValue(count, uint32, "count");
  const out = new Float64Array(count).fill(1);
  for (let i = placeOf(ids, first); i < ids.length && ids[i] - first < count; ++i) out[ids[i] - first] = fractions[i];
  return out;
}

/** Returns the index of the first id that is not below `least`. */
function placeOf(ids: Uint32Array, least: number): number {
  let [begin, end] = [0, ids.length];
  while (begin < end) {
    const middle = Math.floor((begin + end) / 2);
    if (ids[middle] < least) begin = middle + 1;
    else end = middle;
  }
  return begin;
}

/** Joins all that the messages of an answer have. Throws (DATA_LOSS) if that cannot be. */
export function shortenedOf(messages: readonly ShortenedWays[]): Shortened {
  for (const { ids, fractions } of messages) {
    if (ids.length % 4 !== 0 || fractions.length !== 2 * ids.length) {
      const has = `${ids.length} bytes of ids and ${fractions.length} of fractions`;
      throw dataLoss(`shortened has ${has}; it needs 4 and 8 for each`);
    }
  }
  const ids = join(
    Uint32Array,
    messages.map((message) => message.ids),
  );
  const fractions = join(
    Float64Array,
    messages.map((message) => message.fractions),
  );
  const fall = ids.findIndex((id, i) => i > 0 && id <= ids[i - 1]);
  if (fall >= 0) throw dataLoss(`shortened.ids has ${ids[fall]} after ${ids[fall - 1]}; they must ascend strictly`);
  const bad = fractions.find((fraction) => !(fraction >= 0 && fraction < 1));
  if (bad !== undefined) throw dataLoss(`shortened.fractions has ${bad}; it must be in [0, 1)`);
  return { ids, fractions };
}

/** Throws (DATA_LOSS) unless the frame has what the ids name. Without a size, or if it is 0, any number of them will do. */
export function checkShortened({ ids }: Shortened, mode: AdvanceMode, size?: SceneSize): void {
  let limit = 0;
  if (mode === AdvanceMode.PER_MESH) limit = size?.meshes || Infinity;
  if (mode === AdvanceMode.PER_VERTEX) limit = size?.vertices || Infinity;
  const last = ids.at(-1);
  if (last === undefined || last < limit) return;
  throw dataLoss(`shortened.ids names ${last}; the frame has ${limit} that may go a way of their own`);
}
