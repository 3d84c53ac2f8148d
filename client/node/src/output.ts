// The daemon's answer to one frame.

import { checkDone } from "./check_answer.js";
import { type Contacts, type ContactsByKind, contactsOf, limitsOf } from "./contacts.js";
import { Code, CollidedError } from "./errors.js";
import type { ContactChunk, MeshPairs } from "./generated/collided/v1/contact.js";
import type { FrameDone, ShortenedWays } from "./generated/collided/v1/frame.js";
import { type PairOfMeshes, pairsOf } from "./pairs.js";
import { type Shortened, shortenedOf } from "./shortened.js";

/** How a frame ended: `done` with its totals, `error` if it was refused, neither if it was skipped (LATEST_WINS). */
export interface FrameEnd {
  done?: FrameDone;
  error?: CollidedError;
}

/** The whole answer to one frame. A frame that was refused or skipped has no contacts. */
export class FrameOutput implements ContactsByKind {
  readonly vertexTriangle: Contacts;
  readonly edgeEdge: Contacts;
  readonly triangleTriangle: Contacts;
  readonly edgeTriangle: Contacts;
  readonly vertexSolid: Contacts;
  /**
   * The pairs of meshes, one of them a solid, that are not apart, by `first`, then `second`. Discrete frames with Report.ALL have them,
   * in scenes whose `fields` name PAIR_STATES.
   */
  readonly pairs: readonly PairOfMeshes[];
  /** How far each mesh, or vertex, went, in a frame with `advanceMode` PER_MESH, or PER_VERTEX. */
  readonly shortened: Shortened;
  /**
   * Contacts that limit the way, in a frame with `limits`. The whole way would bring each of these pairs nearer than it may come,
   * or is not certain to keep it that far apart.
   * They are vertex-triangle and edge-edge, and have every array but `features` and `signedDistances`, whatever the scene's fields are. `distance` is the
   * least that a pair keeps, in the unit of the positions. `toi`, in [0, 1], is the fraction of the whole way at which the pair comes
   * to that distance, and never later than in truth. `weights` and `normals` are those of `toi`.
   */
  readonly limits: ContactsByKind;
  /** The frame was refused, and the scene is as it was; a stream goes on. */
  readonly error: CollidedError | undefined;
  /** A later frame replaced it (LATEST_WINS). */
  readonly skipped: boolean;
  readonly #done: FrameDone | undefined;

  constructor(
    readonly frameId: bigint,
    chunks: readonly ContactChunk[],
    { done, error }: FrameEnd,
    ways: readonly ShortenedWays[] = [],
    limits: readonly ContactChunk[] = [],
    pairs: readonly MeshPairs[] = [],
  ) {
    ({
      vertexTriangle: this.vertexTriangle,
      edgeEdge: this.edgeEdge,
      triangleTriangle: this.triangleTriangle,
      edgeTriangle: this.edgeTriangle,
      vertexSolid: this.vertexSolid,
    } = contactsOf([...chunks, ...(done?.contacts ?? [])]));
    this.shortened = shortenedOf(done?.shortened ? [...ways, done.shortened] : ways);
    this.limits = limitsOf([...limits, ...(done?.limits ?? [])]);
    this.pairs = pairsOf(done?.pairs ? [...pairs, done.pairs] : pairs);
    if (done) checkDone(done);
    this.error = error;
    this.skipped = !done && !error;
    this.#done = done && { ...done, contacts: [], limits: [], shortened: undefined, pairs: undefined };
  }

  /** Totals and metrics. Throws if the frame was refused or skipped. */
  get done(): FrameDone {
    if (this.#done) return this.#done;
    throw this.error ?? new CollidedError(Code.ABORTED, `frame ${this.frameId} was skipped: a later one replaced it`);
  }

  /** Throws if the frame was refused; returns itself. */
  check(): this {
    if (this.error) throw this.error;
    return this;
  }
}
