// The frames that others send to a scene, as an observer sees them.

import type { ClientReadableStream } from "@grpc/grpc-js";
import { shownBytes, unpackShown } from "./arrays.js";
import { type Rules, check, finite, listOf, uint32 } from "./check.js";
import { checkAsked, checkIds, dataLoss, sizeOf } from "./check_answer.js";
import { type Connection, endOf, onceLate } from "./connection.js";
import { Code, CollidedError } from "./errors.js";
import { type WatchOpened, WatchSceneRequest, type WatchSceneResponse } from "./generated/collided/v1/collision_service.js";
import { AdvanceMode, type FrameDone } from "./generated/collided/v1/frame.js";
import type { PositionFormat, Scene } from "./generated/collided/v1/scene.js";
import { FrameOutput } from "./output.js";
import { checkShortened } from "./shortened.js";

/** What a watcher sees, and how often. */
export interface WatchOptions {
  /** Every so many frames; 0: every one. */
  frameInterval?: number;
  /** 0: as many as are read. */
  maxFramesPerSecond?: number;
  /** The first in canonical order; 0: only their numbers. */
  maxContactsPerKind?: number;
  /** Indices of the meshes whose positions are sent. */
  positionMeshes?: readonly number[];
  /** Positions of every so many vertices; 0: as many as fit in a message. */
  vertexStride?: number;
}

const OPTIONS: Rules<WatchOptions> = {
  frameInterval: uint32,
  maxFramesPerSecond: finite,
  maxContactsPerKind: uint32,
  positionMeshes: listOf(uint32),
  vertexStride: uint32,
};

/** Positions of some vertices of a mesh after a frame: those of vertices 0, vertexStride, 2 * vertexStride and so on. */
export interface SampledPositions {
  mesh: number;
  vertexStride: number;
  positions: Float32Array | Float64Array;
}

/** A frame. Of its contacts it has at most those that the options ask for; `done` has the frame's own totals. */
export class WatchedFrame extends FrameOutput {
  /** That were not shown since the last one. */
  readonly skippedFrames: bigint;
  /** That the frame has besides these. */
  readonly omittedContacts: bigint;
  /** Edits of the scene so far: where it has risen, getScene tells what the scene is made of. */
  readonly editCount: bigint;
  /** One for each of positionMeshes. */
  readonly positions: SampledPositions[];

  constructor(response: WatchSceneResponse, done: FrameDone, format: PositionFormat) {
    super(response.frameId, [], { done });
    this.skippedFrames = response.skippedFrames;
    this.omittedContacts = response.omittedContacts;
    this.editCount = response.editCount;
    this.positions = response.positions.map(({ positions: bytes, ...sample }) => ({
      ...sample,
      positions: unpackShown(bytes, format),
    }));
  }
}

/** An edit may have added meshes since the opening. */
function checkSamples(response: WatchSceneResponse, scene: Scene): void {
  const bytes = shownBytes(scene.spec!.positionFormat);
  const meshes = response.editCount === scene.editCount ? scene.spec!.meshes.length : Infinity;
  const bad = response.positions.find(({ mesh, positions }) => positions.length % bytes !== 0 || mesh >= meshes);
  if (!bad) return;
  throw dataLoss(
    `positions of mesh ${bad.mesh} has ${bad.positions.length} bytes; the scene has ${meshes} meshes, of ${bytes} bytes for a vertex`,
  );
}

/**
 * Iterate over it once: `for await (const frame of watcher)`. Leaving the loop ends the watch. Of frames that come faster than
 * the loop takes them the latest is shown, but for at most 16 that were received already.
 */
export class Watcher implements AsyncIterable<WatchedFrame> {
  readonly #call: ClientReadableStream<WatchSceneResponse>;
  readonly #received: WatchSceneResponse[] = [];
  #opened!: WatchOpened;
  #awaiting: (() => void)[] = [];
  #isCancelled = false;
  #end: { error: CollidedError | undefined } | undefined;

  private constructor(connection: Connection, request: WatchSceneRequest) {
    this.#call = connection.serverStream("watchScene", request, request.sceneId);
    this.#call.on("data", (response: WatchSceneResponse) => {
      this.#received.push(response);
      this.#call.pause();
      this.#wake();
    });
    void endOf(this.#call).then((error) => {
      connection.close();
      this.#end = { error };
      this.#wake();
    });
  }

  /** Opens a watch on a connection, which it closes when it ends. */
  static async open(connection: Connection, sceneId: string, options: WatchOptions): Promise<Watcher> {
    const { positionMeshes = [], ...rest } = options;
    const request = WatchSceneRequest.create({ ...rest, sceneId, positionMeshes: [...positionMeshes] });
    const watcher = new Watcher(connection, request);
    let isLate = false;
    const stop = onceLate(connection.deadlineSeconds, () => {
      isLate = true;
      watcher.cancel();
    });
    const first = await watcher.#next().finally(stop);
    if (isLate) {
      const text = `the daemon did not open the watch within ${connection.deadlineSeconds} s (deadlineSeconds)`;
      throw new CollidedError(Code.DEADLINE_EXCEEDED, text);
    }
    if (first?.event?.$case === "opened") {
      watcher.#opened = first.event.value;
      if (watcher.#opened.scene?.spec) return watcher;
    }
    watcher.cancel();
    throw watcher.#end?.error ?? new CollidedError(Code.DATA_LOSS, "the first message of a watch is not `opened`");
  }

  /** The scene as of the opening, without triangles. */
  get scene(): Scene {
    return this.#opened.scene!;
  }

  /** Of all positions; 0 if none were asked for. */
  get vertexStride(): number {
    return this.#opened.vertexStride;
  }

  /** Waits for the next frame. Rejects once the watch has ended: NOT_FOUND if the scene is gone, CANCELLED after cancel(). */
  async receive(): Promise<WatchedFrame> {
    const response = await this.#next();
    if (response?.event?.$case === "done") {
      checkSamples(response, this.scene);
      const frame = new WatchedFrame(response, response.event.value, this.scene.spec!.positionFormat);
      checkAsked(frame.limits, false); // none are shown
      checkShortened(frame.shortened, AdvanceMode.UNSPECIFIED); // nor these
      if (frame.editCount === this.scene.editCount) checkIds(frame, sizeOf(this.scene.spec));
      return frame;
    }
    throw this.#end?.error ?? new CollidedError(Code.DATA_LOSS, "the daemon ended the watch without a reason");
  }

  /** Frames until the watch ends. Throws unless the scene was deleted, its lease ended, or cancel() ended the watch. */
  async *[Symbol.asyncIterator](): AsyncGenerator<WatchedFrame, void> {
    try {
      for (;;) yield await this.receive();
    } catch (error) {
      const isGone = error instanceof CollidedError && error.code === Code.NOT_FOUND;
      if (!isGone && !this.#isCancelled) throw error;
    } finally {
      this.cancel();
    }
  }

  /** Ends the watch. */
  cancel(): void {
    this.#isCancelled = true;
    this.#call.cancel();
    this.#call.resume();
  }

  /** Undefined once the watch has ended. */
  async #next(): Promise<WatchSceneResponse | undefined> {
    while (this.#received.length === 0 && !this.#end) {
      const news = new Promise<void>((resolve) => this.#awaiting.push(resolve));
      this.#call.resume();
      await news;
    }
    return this.#received.shift();
  }

  #wake(): void {
    for (const resume of this.#awaiting.splice(0)) resume();
  }
}

/** Throws for options that are not known or not of their type. */
export function checkWatchOptions(options: WatchOptions): void {
  check(options, OPTIONS, "options");
}
