// A scene and its stream that survive the loss of the connection, and of the daemon.

import { setTimeout as pause } from "node:timers/promises";
import type { RigidMatrix } from "./arrays.js";
import { type Rules, anything, check, finite, seconds } from "./check.js";
import type { Client } from "./client.js";
import { onceLate } from "./connection.js";
import { Code, CollidedError, invalid } from "./errors.js";
import { type FrameInput, type MeshUpdateInput, frameMessage } from "./frame.js";
import { DetectionMode, MeshMotion, type Scene } from "./generated/collided/v1/scene.js";
import type { FrameOutput } from "./output.js";
import { type SceneInput, sceneSpec } from "./scene.js";
import type { FrameStream } from "./stream.js";

/** How a session is opened. */
export interface SessionOptions {
  /**
   * Where the meshes are before the frame that is being sent: positions of every deformable mesh, the transform of every
   * rigid one that has moved. Called after a loss only. With `advance`, in every mode, that is where moveAlong and poseAlong have
   * them.
   */
  restore: () => readonly MeshUpdateInput[];
  /** Seconds to try to get the connection back before `detect` rejects; 60. */
  giveUpSeconds?: number;
  /** As of createScene. */
  leaseSeconds?: number;
}

const OPTIONS: Rules<SessionOptions> = { restore: anything, giveUpSeconds: seconds, leaseSeconds: finite };
/** Makes a new connection; waits for it so long, or as the client's options say, and not once the signal is aborted. */
type Connect = (patienceSeconds?: number, signal?: AbortSignal) => Promise<Client>;

const FIRST_PAUSE_MS = 50;
const LONGEST_PAUSE_MS = 2000;
const LEAVE_PAUSE_MS = 1000;
const AT_REST: RigidMatrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

/**
 * One frame at a time. Positions are absolute, so that after a loss the scene's first frame, if the scene had to be created
 * again, and one whole frame (`restore`) put it where it was; then the frame that had no answer is sent again.
 */
export class Session {
  /** How often a stream was opened again. */
  reconnects = 0;
  /** How often the scene was created again. */
  recreations = 0;
  readonly #connect: Connect;
  readonly #input: SceneInput;
  readonly #options: SessionOptions;
  #scene!: Scene;
  #stream: FrameStream | undefined;
  #first: FrameInput | undefined; // the scene's, which fixes static and rigid meshes and what is at rest
  #running: Promise<FrameOutput> | undefined; // the frame that is on its way
  #restoreSeconds = 60; // the client's deadline
  #nextLeave = 0; // when leaving a daemon that stops is tried
  readonly #closing = new AbortController();

  private constructor(connect: Connect, input: SceneInput, options: SessionOptions) {
    this.#connect = connect;
    this.#input = structuredClone(input);
    this.#options = options;
  }

  /** With a client of each connection. */
  static async open(connect: Connect, input: SceneInput, options: SessionOptions): Promise<Session> {
    check(options, OPTIONS, "options");
    if (typeof options.restore !== "function") throw invalid("options.restore", "is no function");
    sceneSpec(input); // throws what createScene would throw, before it is copied
    const session = new Session(connect, input, options);
    session.#stream = await session.#withClient((client) => session.#create(client));
    return session;
  }

  /** The scene as it was created last. */
  get scene(): Scene {
    return this.#scene;
  }

  /**
   * Sends a frame and waits for its output, over as many connections as it takes. Rejects if the frame is refused, if there
   * is no connection for giveUpSeconds, and for frames that depend on more than positions: `edit` and `fromLastFraction`. The
   * frame's arrays must stay as they are until then: it may be sent again.
   */
  async detect(frame: FrameInput): Promise<FrameOutput> {
    if (this.#running) throw new CollidedError(Code.FAILED_PRECONDITION, "detect() was called before its last call was over");
    checkRepeatable(frame);
    if (this.#isClosed) throw closed();
    const first = this.#first || frame.trial ? undefined : this.#copyOf(frame);
    this.#running = this.#insist(frame);
    try {
      const output = await this.#running;
      this.#first ??= first;
      return output;
    } finally {
      this.#running = undefined;
    }
  }

  /** Ends the stream and deletes the scene; a frame in flight is withdrawn, and no connection waited for any longer. */
  async close(): Promise<void> {
    this.#closing.abort();
    this.#stream?.cancel();
    await this.#running?.catch(() => {});
    await this.#withClient((client) => deleteIfThere(client, this.#scene));
  }

  get #isClosed(): boolean {
    return this.#closing.signal.aborted;
  }

  #copyOf(frame: FrameInput): FrameInput {
    frameMessage(frame, 0n, this.#scene.spec!.positionFormat); // throws what detect would throw
    return structuredClone(frame);
  }

  async #insist(frame: FrameInput): Promise<FrameOutput> {
    await this.#leave();
    const giveUp = performance.now() + 1000 * (this.#options.giveUpSeconds ?? 60);
    for (let wait = FIRST_PAUSE_MS; ; wait = Math.min(2 * wait, LONGEST_PAUSE_MS)) {
      try {
        this.#stream ??= await this.#reopen((giveUp - performance.now()) / 1000);
        if (this.#isClosed) this.#stream.cancel();
        return await this.#stream.detect(frame);
      } catch (error) {
        if (this.#isClosed) throw closed();
        if (!this.#isLoss(error) || performance.now() + wait > giveUp) throw error;
        this.#stream = undefined;
        await pause(wait, undefined, { signal: this.#closing.signal }).catch(() => {}); // #reopen() is told
      }
    }
  }

  /** A refusal leaves the stream open, whatever its code. */
  #isLoss(error: unknown): boolean {
    const isOpen = this.#stream && !this.#stream.end;
    return !isOpen && (isLost(error) || (error instanceof CollidedError && hasIdledOut(error)));
  }

  async #reopen(patienceSeconds: number): Promise<FrameStream> {
    const patience = Math.max(0, patienceSeconds);
    const stream = await this.#withClient((client) => this.#resume(client), patience, this.#closing.signal);
    await this.#restore(stream);
    this.reconnects += 1;
    return stream;
  }

  async #restore(stream: FrameStream): Promise<void> {
    const stop = onceLate(this.#restoreSeconds, () => stream.cancel()); // the frame then ends as one of a lost connection
    try {
      if (this.#first && stream.scene.lastFrameId === 0n) await stream.detect(this.#first);
      if (this.#first) await stream.detect(this.#restoring());
    } catch (error) {
      stream.cancel();
      throw error;
    } finally {
      stop();
    }
  }

  /**
   * From a daemon that stops to another one, between two frames. Where there is none, frames are answered until it closes the
   * stream, and this is tried again.
   */
  async #leave(): Promise<void> {
    const before = this.#stream;
    if (before?.drainingSeconds === undefined || performance.now() < this.#nextLeave) return;
    this.#nextLeave = performance.now() + LEAVE_PAUSE_MS;
    const scene = this.#scene;
    try {
      await this.#withClient(async (client) => {
        const stream = await this.#create(client);
        await this.#restore(stream);
        this.#stream = stream;
        this.recreations += 1;
        before.cancel();
        await deleteIfThere(client, scene).catch(() => {}); // its daemon ends
      });
    } catch {
      if (this.#stream === before) this.#scene = scene;
    }
  }

  /** Without a first frame nobody can tell what an unanswered one has fixed: the scene begins anew. */
  async #resume(client: Client): Promise<FrameStream> {
    try {
      // Told at once if it is gone, where an endpoint that is gone would be waited for.
      if (this.#first && this.#scene.endpoint) await client.getScene(this.#scene.sceneId);
      if (this.#first) return await client.resume(this.#scene);
      await deleteIfThere(client, this.#scene);
    } catch (error) {
      if (!isNotFound(error) && !(this.#first && isLost(error) && (await this.#isGone(client)))) throw error;
    }
    const stream = await this.#create(client);
    this.recreations += 1;
    return stream;
  }

  /** Proxies may not pass on why a stream was refused: a call is told. */
  async #isGone(client: Client): Promise<boolean> {
    try {
      await client.getScene(this.#scene.sceneId);
      return false;
    } catch (error) {
      if (!isNotFound(error)) throw error;
      return true;
    }
  }

  async #create(client: Client): Promise<FrameStream> {
    this.#scene = await client.createScene(this.#input, { leaseSeconds: this.#options.leaseSeconds ?? 0 });
    return client.stream(this.#scene);
  }

  /** Stands still, so that it costs little and meets nothing on a way that nobody went. */
  #restoring(): FrameInput {
    const restored = this.#options.restore();
    const updates = [...restored, ...this.#unmoved(restored)];
    if (this.#input.mode === DetectionMode.DCD) return { updates };
    if (this.#input.mode === DetectionMode.DCD_AND_CCD) return { updates, mode: DetectionMode.DCD };
    return { updates: updates.map(standingStill) };
  }

  /** Rigid meshes that have not moved, as the first frame left them: the frame without an answer may have moved them. */
  #unmoved(moved: readonly MeshUpdateInput[]): MeshUpdateInput[] {
    const named = new Set(moved.map(({ mesh }) => mesh));
    const transforms = new Map(this.#first?.updates?.map(({ mesh, transform }) => [mesh, transform]));
    return this.#input.meshes.flatMap(({ motion }, mesh) =>
      motion === MeshMotion.RIGID && !named.has(mesh) ? { mesh, transform: transforms.get(mesh) ?? AT_REST } : [],
    );
  }

  async #withClient<T>(use: (client: Client) => Promise<T>, patienceSeconds?: number, signal?: AbortSignal): Promise<T> {
    const client = await this.#connect(patienceSeconds, signal);
    this.#restoreSeconds = client.deadlineSeconds;
    try {
      return await use(client);
    } finally {
      await client.close();
    }
  }
}

/** A stream that waited too long for a frame has ended, and the scene's lease runs. */
function hasIdledOut(error: CollidedError): boolean {
  return error.code === Code.RESOURCE_EXHAUSTED && error.quota.includes("max_idle_seconds");
}

function isNotFound(error: unknown): boolean {
  return error instanceof CollidedError && error.code === Code.NOT_FOUND;
}

function isLost(error: unknown): boolean {
  return error instanceof CollidedError && error.isConnectionLost;
}

async function deleteIfThere(client: Client, scene: Scene): Promise<void> {
  await client.deleteScene(scene).catch((error: unknown) => {
    if (!isNotFound(error)) throw error;
  });
}

function closed(): CollidedError {
  return new CollidedError(Code.FAILED_PRECONDITION, "the session is closed");
}

function standingStill({ mesh, positions, transform }: MeshUpdateInput): MeshUpdateInput {
  const still = positions && { positions, startPositions: positions };
  return { mesh, ...still, ...(transform && { transform, startTransform: transform }) };
}

function checkRepeatable(frame: FrameInput): void {
  for (const [name, field] of [
    ["edit", "edit"],
    ["fromLastFraction", "from_last_fraction"],
    ["frameId", "frame_id"],
  ] as const) {
    if (frame?.[name] !== undefined) throw invalid(`frame.${field}`, "cannot be restored by a session; use a stream");
  }
}
