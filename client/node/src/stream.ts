// Frames in, contacts out: one stream to one scene.

import type { ClientDuplexStream } from "@grpc/grpc-js";
import { type Rules, check, oneOf, string, uint32 } from "./check.js";
import { MOST_FRAMES, checkAsked, checkIds, checkTotal, dataLoss, sceneOf, sizeOf } from "./check_answer.js";
import { type Connection, endOf, onceLate } from "./connection.js";
import { Code, CollidedError, errorOfFrame } from "./errors.js";
import { type FrameInput, frameIdOf, frameMessage } from "./frame.js";
import {
  DeliveryPolicy,
  OpenStream,
  type StreamOpened,
  type StreamFramesResponse,
} from "./generated/collided/v1/collision_service.js";
import type { ContactChunk, MeshPairs } from "./generated/collided/v1/contact.js";
import { AdvanceMode, type ShortenedWays } from "./generated/collided/v1/frame.js";
import type { Scene } from "./generated/collided/v1/scene.js";
import { type FrameEnd, FrameOutput } from "./output.js";
import { checkShortened } from "./shortened.js";

/** How a stream is opened. */
export interface StreamOptions {
  /** Frames in flight, up to the daemon's limit; 0: the daemon chooses. */
  window?: number;
  /** Whether each frame is answered, or waiting ones give way to later ones. */
  delivery?: DeliveryPolicy;
  /** The scene's; takes it over from a stream that may still be open. */
  resumeToken?: string;
}

const OPTIONS: Rules<StreamOptions> = { window: uint32, delivery: oneOf({ DeliveryPolicy }), resumeToken: string };

/** What becomes of a frame's output, or of the stream's end before it. */
interface Taker {
  give(output: FrameOutput): void;
  fail(error: CollidedError): void;
  /** Whether `receive` or the iterator has it. */
  isKept: boolean;
}

interface Unanswered extends Taker {
  id: bigint;
  chunks: ContactChunk[];
  ways: ShortenedWays[];
  mode: AdvanceMode;
  limits: ContactChunk[];
  pairs: MeshPairs[];
  hasLimits: boolean;
}

/** Outputs come in the order of the frames. The stream has its own connection, and reads answers as they come. */
export class FrameStream implements AsyncIterable<FrameOutput> {
  readonly #connection: Connection;
  readonly #call: ClientDuplexStream<Buffer, StreamFramesResponse>;
  readonly #maxMessageBytes: bigint;
  readonly #unanswered: Unanswered[] = []; // in flight, or waiting for a credit
  readonly #ready: FrameOutput[] = [];
  readonly #ended: Promise<void>;
  readonly #asked: OpenStream;
  readonly #maySkip: boolean; // LATEST_WINS
  #size = sizeOf(undefined); // as of the opening
  #hasEdits = false; // the scene may have another size by now
  #opened: StreamOpened | undefined;
  #isOpen = () => {};
  #onAnswer = () => {};
  #lastId = 0n;
  #credits = 0;
  #awaitingCredit: (() => void)[] = [];
  #awaitingOutput: ((output?: FrameOutput) => void)[] = [];
  #unsent = 0;
  #isFinishing = false;
  #end: { error: CollidedError | undefined } | undefined;
  #malformed: CollidedError | undefined;
  #drainsAt: number | undefined;

  private constructor(connection: Connection, asked: OpenStream, maxMessageBytes: bigint) {
    this.#connection = connection;
    this.#asked = asked;
    this.#maySkip = asked.delivery === DeliveryPolicy.LATEST_WINS;
    this.#maxMessageBytes = maxMessageBytes;
    this.#call = connection.duplex("streamFrames", asked.sceneId);
    this.#ended = endOf(this.#call).then((error) => {
      connection.close();
      this.#conclude(this.#malformed ?? error);
    });
  }

  /** Opens a stream on a connection, which it closes when it ends. */
  static async open(
    connection: Connection,
    scene: Scene,
    options: StreamOptions,
    maxMessageBytes: bigint,
  ): Promise<FrameStream> {
    const asked = OpenStream.create({ ...options, sceneId: scene.sceneId });
    const opening = connection.encode("streamFrames", { request: { $case: "open", value: asked } });
    const stream = new FrameStream(connection, asked, maxMessageBytes);
    await stream.#open(opening);
    return stream;
  }

  /** The scene as of the opening: lastFrameId is the last frame that was applied before this stream. */
  get scene(): Scene {
    return this.#opened!.scene!;
  }

  /** How many frames may be in flight. */
  get window(): number {
    return this.#opened!.window;
  }

  /** Set once the stream has ended: with an error, unless `finish` ended it. */
  get end(): { error: CollidedError | undefined } | undefined {
    return this.#end;
  }

  /** Seconds until the daemon, which is stopping, closes the stream; undefined unless it is stopping. */
  get drainingSeconds(): number | undefined {
    return this.#drainsAt && Math.max(0, (this.#drainsAt - performance.now()) / 1000);
  }

  /**
   * Waits until fewer frames than the window are in flight, then sends; resolves with the frame's id. The frame is encoded
   * at once, so that its arrays may change as soon as the call has returned. `receive` or the iterator has its output.
   */
  async send(frame: FrameInput): Promise<bigint> {
    return this.#post(frame, { give: (output) => this.#keep(output), fail: () => {}, isKept: true });
  }

  /** Sends a frame and waits for its output. Rejects if the frame was refused; the stream goes on. */
  async detect(frame: FrameInput): Promise<FrameOutput> {
    const output = await new Promise<FrameOutput>((give, fail) => {
      this.#post(frame, { give, fail, isKept: false }).catch(fail);
    });
    return output.check();
  }

  /** The next output of `send`. Rejects once the stream has ended, and if no frame is in flight that others do not await. */
  async receive(): Promise<FrameOutput> {
    const toCome = this.#unanswered.filter(({ isKept }) => isKept).length;
    if (this.#ready.length === 0 && toCome <= this.#awaitingOutput.length && !this.#end) {
      throw new CollidedError(Code.FAILED_PRECONDITION, "receive() was called with no frame of send() in flight");
    }
    const output = await this.#next();
    if (!output) throw this.#whyEnded();
    return output;
  }

  /** Outputs of `send`, until the stream has ended. Throws unless `finish` ended it. */
  async *[Symbol.asyncIterator](): AsyncGenerator<FrameOutput, void> {
    for (let output = await this.#next(); output; output = await this.#next()) yield output;
    if (this.#end?.error) throw this.#end.error;
  }

  /**
   * Tells the daemon that no more frames will come, after those that wait for a credit, and waits until all are answered.
   * Outputs can still be received. Rejects with DEADLINE_EXCEEDED if none is answered, and the stream does not end, for as
   * long as a call may take.
   */
  async finish(): Promise<void> {
    if (!this.#isFinishing) {
      this.#isFinishing = true;
      this.#endIfSent();
    }
    while (!this.#end) {
      const answered = new Promise<void>((resolve) => (this.#onAnswer = resolve));
      const stop = onceLate(this.#connection.deadlineSeconds, () => this.#giveUp("answer a frame or end the stream"));
      await Promise.race([this.#ended, answered]).finally(stop);
    }
    if (this.#end?.error) throw this.#end.error;
  }

  /** Ends the stream; frames in flight are withdrawn. */
  cancel(): void {
    this.#call.cancel();
  }

  #giveUp(what: string): void {
    const text = `the daemon did not ${what} within ${this.#connection.deadlineSeconds} s (deadlineSeconds)`;
    this.#malformed ??= new CollidedError(Code.DEADLINE_EXCEEDED, text);
    this.cancel();
  }

  async #open(opening: Buffer): Promise<void> {
    const opened = new Promise<void>((resolve) => (this.#isOpen = resolve));
    this.#call.on("data", (response: StreamFramesResponse) => this.#take(response));
    this.#call.write(opening);
    const stop = onceLate(this.#connection.deadlineSeconds, () => this.#giveUp("open the stream"));
    await Promise.race([opened, this.#ended]).finally(stop);
    if (!this.#opened) throw this.#whyEnded();
  }

  #begin(response: StreamFramesResponse["response"]): void {
    if (response?.$case !== "opened") throw dataLoss("the daemon's first answer does not open the stream");
    const { window } = response.value;
    const { sceneId, spec } = sceneOf(response.value);
    const most = this.#asked.window || MOST_FRAMES;
    if (sceneId !== this.#asked.sceneId) throw dataLoss(`the daemon opened scene ${sceneId} instead of ${this.#asked.sceneId}`);
    if (window < 1 || window > most) throw dataLoss(`opened.window is ${window}; it must be from 1 to ${most}`);
    this.#opened = response.value;
    this.#size = sizeOf(spec);
    this.#lastId = this.scene.lastFrameId;
    this.#credits = this.window;
    this.#isOpen();
  }

  async #post(input: FrameInput, taker: Taker): Promise<bigint> {
    const id = input?.frameId === undefined ? this.#lastId + 1n : frameIdOf(input);
    const bytes = this.#encode(input, id);
    if (this.#end || this.#isFinishing) throw this.#whyEnded();
    if (input?.edit) this.#hasEdits = true;
    if (id > this.#lastId) this.#lastId = id; // else it is refused
    const asked = { mode: input?.advanceMode ?? AdvanceMode.UNSPECIFIED, hasLimits: input?.limits ?? false };
    this.#unanswered.push({ id, chunks: [], ways: [], limits: [], pairs: [], ...asked, ...taker });
    this.#unsent += 1;
    if (this.#credits > 0) this.#credits -= 1;
    else await new Promise<void>((resolve) => this.#awaitingCredit.push(resolve));
    this.#unsent -= 1;
    if (this.#end) throw this.#whyEnded();
    this.#call.write(bytes);
    this.#endIfSent();
    return id;
  }

  #endIfSent(): void {
    if (this.#isFinishing && this.#unsent === 0) this.#call.end();
  }

  #encode(input: FrameInput, id: bigint): Buffer {
    const value = frameMessage(input, id, this.scene.spec!.positionFormat);
    const bytes = this.#connection.encode("streamFrames", { request: { $case: "frame", value } });
    if (bytes.length <= this.#maxMessageBytes) return bytes;
    const text = `frame is ${bytes.length} bytes; the daemon's limit is ${this.#maxMessageBytes} (--max-message-mb)`;
    throw new CollidedError(Code.RESOURCE_EXHAUSTED, text, { field: "frame" });
  }

  /** An answer that contradicts itself ends the stream: what follows cannot be trusted. */
  #take({ frameId, response }: StreamFramesResponse): void {
    try {
      if (!this.#opened) return this.#begin(response);
      if (response?.$case === "draining") this.#drainsAt = performance.now() + 1000 * response.value.deadlineSeconds;
      if (response?.$case === "contacts") this.#oldest(frameId).chunks.push(response.value);
      if (response?.$case === "shortened") this.#oldest(frameId).ways.push(response.value);
      if (response?.$case === "limits") this.#oldest(frameId).limits.push(response.value);
      if (response?.$case === "pairs") this.#oldest(frameId).pairs.push(response.value);
      if (response?.$case === "done") this.#complete(frameId, { done: response.value });
      if (response?.$case === "error") this.#complete(frameId, { error: errorOfFrame(response.value) });
      if (response?.$case === "skipped" && this.#maySkip) return this.#complete(frameId, {});
      if (response && ["opened", "skipped", "worldErrors"].includes(response.$case)) {
        throw dataLoss(`the daemon answers frame ${frameId} with ${response.$case}, which is no answer of this stream`);
      }
    } catch (error) {
      this.#malformed = error as CollidedError;
      this.cancel();
    }
  }

  #oldest(frameId: bigint): Unanswered {
    const oldest = this.#unanswered[0];
    if (oldest?.id === frameId) return oldest;
    throw dataLoss(`an answer is of frame ${frameId}; the oldest in flight is ${oldest?.id ?? "none"}`);
  }

  #complete(frameId: bigint, end: FrameEnd): void {
    const { chunks, ways, mode, limits, hasLimits, pairs, give } = this.#oldest(frameId);
    const output = new FrameOutput(frameId, chunks, end, ways, limits, pairs);
    if (end.done) checkTotal(end.done, output);
    checkAsked(output.limits, hasLimits);
    checkShortened(output.shortened, mode, this.#hasEdits ? undefined : this.#size);
    if (!this.#hasEdits) checkIds(output, this.#size);
    this.#unanswered.shift();
    const next = this.#awaitingCredit.shift();
    if (next) next();
    else this.#credits += 1;
    this.#onAnswer();
    give(output);
  }

  #keep(output: FrameOutput): void {
    const next = this.#awaitingOutput.shift();
    if (next) next(output);
    else this.#ready.push(output);
  }

  /** Undefined once the stream has ended. */
  async #next(): Promise<FrameOutput | undefined> {
    if (this.#ready.length > 0 || this.#end) return this.#ready.shift();
    return new Promise((resolve) => this.#awaitingOutput.push(resolve));
  }

  #conclude(error: CollidedError | undefined): void {
    this.#end = { error };
    for (const { fail } of this.#unanswered.splice(0)) fail(this.#whyEnded());
    for (const resume of [...this.#awaitingCredit.splice(0), ...this.#awaitingOutput.splice(0)]) resume();
  }

  #whyEnded(): CollidedError {
    if (this.#end?.error) return this.#end.error;
    if (this.#isFinishing) return new CollidedError(Code.FAILED_PRECONDITION, "the stream has ended, as finish() asked for");
    return new CollidedError(Code.UNAVAILABLE, "the stream has ended");
  }
}

/** Throws for options that are not known or not of their type. */
export function checkStreamOptions(options: StreamOptions): void {
  check(options, OPTIONS, "options");
}
