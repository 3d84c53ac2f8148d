// A connection to a daemon: scenes and streams. Everything rejects with a CollidedError.

import { randomBytes } from "node:crypto";
import { setTimeout as pause } from "node:timers/promises";
import { type Rules, check, checkValue, finite, string, uint32 } from "./check.js";
import { MOST_SCENES, checkAsked, checkDone, checkTotal, dataLoss, sceneOf } from "./check_answer.js";
import { type ConnectOptions, type Connection, Connector, Limit } from "./connection.js";
import { OwnDaemon } from "./daemon.js";
import { Code, CollidedError, invalid } from "./errors.js";
import { Features } from "./features.js";
import { type FrameInput, frameIdOf, frameMessage } from "./frame.js";
import {
  CreateSceneRequest,
  DetectFrameRequest,
  type EstimateSceneResponse,
  type GetServerInfoResponse,
} from "./generated/collided/v1/collision_service.js";
import type { Scene } from "./generated/collided/v1/scene.js";
import { type MeshElements, readElements } from "./mesh_elements.js";
import { FrameOutput } from "./output.js";
import { type SceneInput, sceneSpec } from "./scene.js";
import { Session, type SessionOptions } from "./session.js";
import { checkShortened } from "./shortened.js";
import { FrameStream, type StreamOptions, checkStreamOptions } from "./stream.js";
import { takeLarge, uploadAll } from "./upload.js";
import { type WatchOptions, Watcher, checkWatchOptions } from "./watcher.js";

/** How a scene is created. */
export interface CreateOptions {
  /** Seconds without a stream or a call after which it is deleted; 0: the daemon's default. */
  leaseSeconds?: number;
}

const CREATE: Rules<CreateOptions> = { leaseSeconds: finite };
const CREATE_TRIES = 3;
const ELEMENTS_A_SECOND = (1 << 19) / 12; // that reading a mesh may take longer for, as an upload may

/**
 * Connects to the daemon at `address`, host:port or unix:/path. Without an address it starts a daemon of its own, which
 * close() stops: $COLLIDED_DAEMON, or `collided` on the PATH.
 */
export async function connect(address?: string, options: ConnectOptions = {}): Promise<Client> {
  if (address !== undefined) return Client.open(new Connector(address, options));
  const daemon = await OwnDaemon.start();
  try {
    return await Client.open(new Connector(daemon.address, options), daemon);
  } catch (error) {
    await daemon.stop();
    throw error;
  }
}

export class Client {
  private constructor(
    private readonly connector: Connector,
    private readonly connection: Connection,
    /** Version, devices and limits of the daemon when the client connected. */
    readonly serverInfo: GetServerInfoResponse,
    private readonly daemon: OwnDaemon | undefined,
  ) {}

  /** `daemon` is stopped when the client is closed. The rest is of `connect`. */
  static async open(connector: Connector, daemon?: OwnDaemon, patienceSeconds?: number, signal?: AbortSignal): Promise<Client> {
    const connection = await connector.connect(undefined, patienceSeconds, signal);
    try {
      const info = await connection.unary("getServerInfo", {});
      connection.features = new Features(info, connector.address);
      return new Client(connector, connection, info, daemon);
    } catch (error) {
      connection.close();
      throw error;
    }
  }

  /** Seconds that a call may take. */
  get deadlineSeconds(): number {
    return this.connection.deadlineSeconds;
  }

  /** Version, devices and limits of the daemon. */
  getServerInfo(): Promise<GetServerInfoResponse> {
    return this.connection.unary("getServerInfo", {});
  }

  /** Creates a scene, ready for frames. Retries if the answer is lost, without ever creating two. */
  async createScene(input: SceneInput, options: CreateOptions = {}): Promise<Scene> {
    check(options, CREATE, "options");
    const spec = sceneSpec(input);
    const uploads = takeLarge(spec, this.serverInfo.limits?.maxMessageBytes ?? 0n);
    const requestId = randomBytes(16).toString("hex");
    const scene = await this.#create(CreateSceneRequest.create({ requestId, leaseSeconds: options.leaseSeconds ?? 0, spec }));
    if (uploads.size === 0) return scene;
    try {
      return await uploadAll(this.connection, scene.sceneId, uploads);
    } catch (error) {
      await this.deleteScene(scene).catch(() => {}); // the upload's error is the one to tell
      throw error;
    }
  }

  /** What createScene of the same input would cost, before anything is made; no triangle is sent. */
  async estimateScene(input: SceneInput): Promise<EstimateSceneResponse> {
    const spec = sceneSpec(input);
    for (const mesh of spec.meshes) mesh.triangles = new Uint8Array(); // their number stays
    return this.connection.unary("estimateScene", { spec });
  }

  /** State and memory of a scene. */
  async getScene(sceneId: string): Promise<Scene> {
    checkValue(sceneId, string, "scene_id");
    return sceneOf(await this.connection.unary("getScene", { sceneId }, sceneId));
  }

  /** What a mesh of a scene is made of now, whoever created it. `mesh`: its index in the scene's spec. */
  async getMesh(scene: Scene | string, mesh: number): Promise<MeshElements> {
    const sceneId = typeof scene === "string" ? scene : sceneIdOf(scene);
    checkValue(mesh, uint32, "mesh");
    const limit = new Limit(this.connection.deadlineSeconds);
    return readElements((firstElement) =>
      this.connection.unary("getMesh", { sceneId, mesh, firstElement }, sceneId, limit.left(firstElement / ELEMENTS_A_SECOND)),
    );
  }

  /** This client's scenes, by id. All pages together take no longer than a call may. */
  async listScenes(): Promise<Scene[]> {
    const scenes: Scene[] = [];
    const limit = new Limit(this.connection.deadlineSeconds);
    let pageToken = "";
    do {
      const page = await this.connection.unary("listScenes", { pageSize: 0, pageToken }, "", limit.left());
      for (const scene of page.scenes) {
        const last = scenes.at(-1);
        if (last && scene.sceneId <= last.sceneId)
          throw dataLoss(`scenes names ${scene.sceneId} after ${last.sceneId}; ids must ascend`);
        scenes.push(scene);
      }
      pageToken = page.nextPageToken;
      if (pageToken !== "" && (page.scenes.length === 0 || scenes.length >= MOST_SCENES)) {
        throw dataLoss(`next_page_token is set after a page of ${page.scenes.length} scenes, ${scenes.length} in all`);
      }
    } while (pageToken !== "");
    return scenes;
  }

  /** Deletes a scene and frees its memory; its stream ends with NOT_FOUND. */
  async deleteScene(scene: Scene | string): Promise<void> {
    const sceneId = typeof scene === "string" ? scene : sceneIdOf(scene);
    await this.connection.unary("deleteScene", { sceneId }, sceneId);
  }

  /** One frame, one answer, of a scene without an open stream. Rejects if the frame is refused. `frame.frameId` is needed. */
  async detect(scene: Scene, frame: FrameInput): Promise<FrameOutput> {
    const sceneId = sceneIdOf(scene);
    const frameId = frameIdOf(frame);
    const request: DetectFrameRequest = { sceneId, frame: frameMessage(frame, frameId, scene.spec!.positionFormat) };
    const answer = await this.connection.unary("detectFrame", request, sceneId);
    const done = checkDone(answer.done);
    const output = new FrameOutput(frameId, answer.contacts, { done });
    checkTotal(done, output);
    checkAsked(output.limits, request.frame!.limits);
    checkShortened(output.shortened, request.frame!.advanceMode);
    return output;
  }

  /** Opens a stream, on a connection of its own to the scene's endpoint. */
  async stream(scene: Scene, options: StreamOptions = {}): Promise<FrameStream> {
    sceneIdOf(scene);
    checkStreamOptions(options);
    return this.#onOwnConnection(
      (connection) => FrameStream.open(connection, scene, options, this.serverInfo.limits?.maxMessageBytes ?? 0n),
      scene.endpoint || undefined,
    );
  }

  /**
   * Resumes a scene whose stream broke, and takes it over from one that may still be open: send the frames after the new
   * stream's scene.lastFrameId again.
   */
  async resume(scene: Scene, options: StreamOptions = {}): Promise<FrameStream> {
    return this.stream(scene, { ...options, resumeToken: scene?.resumeToken });
  }

  /** Watches the frames that others send to a scene of this client, on a connection of its own. */
  async watch(scene: Scene | string, options: WatchOptions = {}): Promise<Watcher> {
    const sceneId = typeof scene === "string" ? scene : sceneIdOf(scene);
    checkWatchOptions(options);
    return this.#onOwnConnection((connection) => Watcher.open(connection, sceneId, options));
  }

  /** Creates a scene and a stream that survive the loss of the connection and of the daemon. */
  session(input: SceneInput, options: SessionOptions): Promise<Session> {
    return Session.open((...patience) => Client.open(this.connector, undefined, ...patience), input, options);
  }

  /** Closes the connection, and stops the daemon if it is the client's own. Streams and watches have their own connections. */
  async close(): Promise<void> {
    this.connection.close();
    await this.daemon?.stop();
  }

  /** Calls `open` with a new connection, which what it opens closes in the end. */
  async #onOwnConnection<T>(open: (connection: Connection) => Promise<T>, address?: string): Promise<T> {
    const connection = await this.connector.connect(address);
    connection.features = this.connection.features;
    try {
      return await open(connection);
    } catch (error) {
      connection.close(); // nothing else does if no call has begun
      throw error;
    }
  }

  async #create(request: CreateSceneRequest): Promise<Scene> {
    for (let tries = 1; ; ++tries) {
      try {
        return sceneOf(await this.connection.unary("createScene", request));
      } catch (error) {
        const isLost = error instanceof CollidedError && error.code === Code.UNAVAILABLE;
        if (!isLost || tries === CREATE_TRIES) throw error;
        await pause(200 * tries);
      }
    }
  }
}

function sceneIdOf(scene: Scene): string {
  if (typeof scene?.sceneId === "string" && scene.spec) return scene.sceneId;
  throw invalid("scene", "is not one of createScene or getScene");
}
