// Connections to one address with its credentials, and calls on them.

import { readFileSync } from "node:fs";
import { isIP } from "node:net";
import {
  type ChannelOptions,
  Client as GrpcClient,
  type ClientDuplexStream,
  type ClientReadableStream,
  type ClientWritableStream,
  Metadata,
  type StatusObject,
  connectivityState,
  credentials,
} from "@grpc/grpc-js";
import { type Rules, boolean, check, join, seconds, show, string } from "./check.js";
import { Code, CollidedError, errorOfStatus, invalid } from "./errors.js";
import type { Features } from "./features.js";
import { CollisionServiceDefinition } from "./generated/collided/v1/collision_service.js";

/** How a client reaches its daemon. Files are in PEM format. TLS is used if tlsCa is set, else plain text. */
export interface ConnectOptions {
  /** Seconds to wait for the connection; 5. */
  patienceSeconds?: number;
  /** Seconds for one call; 60. Of a stream or a watch for the first answer, and for the end. */
  deadlineSeconds?: number;
  /** Bearer token. */
  token?: string;
  /** File with the certificates to trust. */
  tlsCa?: string;
  /** File of the client's own certificate (mTLS); needs tlsKey. */
  tlsCertificate?: string;
  /** File of its private key. */
  tlsKey?: string;
  /** Name in the daemon's certificate if it is not the address's. */
  tlsServerName?: string;
  /** Send the token in plain text even to another host. */
  allowInsecureToken?: boolean;
}

const OPTIONS: Rules<ConnectOptions> = {
  patienceSeconds: seconds,
  deadlineSeconds: seconds,
  token: string,
  tlsCa: string,
  tlsCertificate: string,
  tlsKey: string,
  tlsServerName: string,
  allowInsecureToken: boolean,
};

/** Answers larger than gRPC's own default are never sent. */
const MAX_ANSWER_BYTES = 4 << 20;

type Methods = (typeof CollisionServiceDefinition)["methods"];
type Message<T> = T extends { create(base?: never): infer M } ? M : never;
type Request<N extends keyof Methods> = Message<Methods[N]["requestType"]>;
type Answer<N extends keyof Methods> = Message<Methods[N]["responseType"]>;

interface Coder<T> {
  encode(message: T): { finish(): Uint8Array };
  decode(bytes: Uint8Array): T;
}

/** Checks and reads the options once; each `connect` makes a connection of its own. */
export class Connector {
  readonly #options: ConnectOptions;
  readonly #credentials;

  constructor(
    readonly address: string,
    options: ConnectOptions,
  ) {
    if (typeof address !== "string" || address === "") {
      throw invalid("address", `is ${show(address)}; it must be host:port or unix:/path`);
    }
    check(options, OPTIONS, "options");
    this.#options = { ...options };
    checkTogether(this.#options, address);
    this.#credentials = credentialsOf(this.#options);
  }

  /**
   * A connection to this address, or to another one with the same credentials. UNAVAILABLE if no daemon answers in time, or
   * before the signal is aborted.
   */
  async connect(
    address = this.address,
    patienceSeconds = this.#options.patienceSeconds ?? 5,
    signal?: AbortSignal,
  ): Promise<Connection> {
    checkToken(this.#options, address);
    const local = isLocalAddress(address);
    const channel: ChannelOptions = {
      "grpc.max_receive_message_length": MAX_ANSWER_BYTES,
      "grpc.use_local_subchannel_pool": 1, // each stream has a connection of its own
      "grpc.keepalive_time_ms": 10_000,
      "grpc.keepalive_timeout_ms": 5_000,
      "grpc.keepalive_permit_without_calls": 1,
      "grpc.initial_reconnect_backoff_ms": 100,
      "grpc.max_reconnect_backoff_ms": 2_000,
      "grpc.enable_retries": 0, // they would keep a copy of each message
      ...(local ? { "grpc.enable_http_proxy": 0 } : {}),
      ...(this.#options.tlsServerName ? { "grpc.ssl_target_name_override": this.#options.tlsServerName } : {}),
    };
    const connection = new Connection(new GrpcClient(address, this.#credentials, channel), this.#options);
    const giveUp = () => connection.close();
    if (signal?.aborted) giveUp();
    signal?.addEventListener("abort", giveUp);
    await connection.ready(address, patienceSeconds).finally(() => signal?.removeEventListener("abort", giveUp));
    return connection;
  }
}

/** One connection. */
export class Connection {
  /** What the daemon lacks; undefined until its facts are here, and requests are not checked before. */
  features: Features | undefined;
  readonly #grpc: GrpcClient;
  readonly #options: ConnectOptions;
  #isClosed = false;

  constructor(client: GrpcClient, options: ConnectOptions) {
    this.#grpc = client;
    this.#options = options;
  }

  /** Waits until it is connected, or closes it. */
  async ready(address: string, patienceSeconds: number): Promise<void> {
    if (await this.#becomesReady(Date.now() + 1000 * patienceSeconds)) return;
    // gRPC tells the reason to calls alone.
    const why = await this.unary("getServerInfo", {}, "", 1).then(
      () => undefined,
      (error: CollidedError) => error,
    );
    if (why === undefined) return;
    this.close();
    const reason = why.code === Code.UNAVAILABLE ? `: ${why.message}` : "";
    throw new CollidedError(
      Code.UNAVAILABLE,
      `no daemon answers at ${address} within ${patienceSeconds} s (patienceSeconds)${reason}`,
    );
  }

  /** GrpcClient.waitForReady would open a channel again that is closed meanwhile. */
  async #becomesReady(until: number): Promise<boolean> {
    const channel = this.#grpc.getChannel();
    for (let isLate = false; !isLate && !this.#isClosed; ) {
      const state = channel.getConnectivityState(true);
      if (state === connectivityState.READY) return true;
      isLate = await new Promise((resolve) => channel.watchConnectivityState(state, until, (error) => resolve(!!error)));
    }
    return false;
  }

  unary<N extends keyof Methods>(name: N, request: Request<N>, sceneId = "", limitSeconds?: number): Promise<Answer<N>> {
    const { path, decode } = method(name);
    return new Promise((resolve, reject) => {
      const bytes = this.encode(name, request);
      const deadline = this.#deadline(limitSeconds);
      this.#client().makeUnaryRequest(path, same, decode, bytes, this.#metadata(sceneId), { deadline }, (error, answer) =>
        error ? reject(errorOfStatus(error)) : resolve(answer as Answer<N>),
      );
    });
  }

  /** A call with many requests, which `encode` has made; `done` is called once, with an error or the answer. */
  upload<N extends keyof Methods>(
    name: N,
    sceneId: string,
    limitSeconds: number,
    done: (error: CollidedError | undefined, answer: Answer<N> | undefined) => void,
  ): ClientWritableStream<Buffer> {
    const { path, decode } = method(name);
    const deadline = this.#deadline(limitSeconds);
    return this.#client().makeClientStreamRequest(
      path,
      same,
      decode,
      this.#metadata(sceneId),
      { deadline },
      (error, answer) => done(error ? errorOfStatus(error) : undefined, answer),
    );
  }

  serverStream<N extends keyof Methods>(name: N, request: Request<N>, sceneId: string): ClientReadableStream<Answer<N>> {
    const { path, decode } = method(name);
    return this.#client().makeServerStreamRequest(path, same, decode, this.encode(name, request), this.#metadata(sceneId));
  }

  /** A call with many requests, which `encode` has made, and many answers. */
  duplex<N extends keyof Methods>(name: N, sceneId: string): ClientDuplexStream<Buffer, Answer<N>> {
    const { path, decode } = method(name);
    return this.#client().makeBidiStreamRequest(path, same, decode, this.#metadata(sceneId));
  }

  /** Encodes a request, as every request is that is sent. Throws UNIMPLEMENTED if the daemon is too old for it. */
  encode<N extends keyof Methods>(name: N, request: Request<N>): Buffer {
    const { rpc, encode } = method(name);
    const bytes = encode(request);
    this.features?.check(rpc, bytes);
    return bytes;
  }

  get deadlineSeconds(): number {
    return this.#options.deadlineSeconds ?? 60;
  }

  close(): void {
    this.#isClosed = true;
    this.#grpc.close();
  }

  #client(): GrpcClient {
    if (!this.#isClosed) return this.#grpc;
    throw new CollidedError(Code.FAILED_PRECONDITION, "the client is closed");
  }

  #deadline(limitSeconds = this.deadlineSeconds): number {
    return Date.now() + 1000 * limitSeconds;
  }

  /** The token, and the scene's id, by which proxies find its daemon. */
  #metadata(sceneId: string): Metadata {
    const metadata = new Metadata();
    // Not as call credentials, which gRPC refuses on plain-text channels, Unix sockets included.
    if (this.#options.token) metadata.set("authorization", `Bearer ${this.#options.token}`);
    if (isVisible(sceneId)) metadata.set("scene-id", sceneId);
    return metadata;
  }
}

function method<N extends keyof Methods>(name: N) {
  const { fullName, methods } = CollisionServiceDefinition;
  const { name: rpc, requestType, responseType } = methods[name];
  const request = requestType as unknown as Coder<Request<N>>;
  const answer = responseType as unknown as Coder<Answer<N>>;
  return {
    rpc,
    path: `/${fullName}/${rpc}`,
    encode: (message: Request<N>): Buffer => bufferOf(request.encode(message).finish()),
    decode: (bytes: Buffer): Answer<N> => answer.decode(bytes),
  };
}

/** gRPC's serializer of requests that are encoded already. */
function same(bytes: Buffer): Buffer {
  return bytes;
}

/** Buffer.from(bytes) would copy. */
function bufferOf(bytes: Uint8Array): Buffer {
  return Buffer.from(bytes.buffer, bytes.byteOffset, bytes.byteLength);
}

function credentialsOf(options: ConnectOptions) {
  if (!options.tlsCa) return credentials.createInsecure();
  const read = (name: "tlsCa" | "tlsCertificate" | "tlsKey") => (options[name] ? readFile(options[name], name) : null);
  return credentials.createSsl(read("tlsCa"), read("tlsKey"), read("tlsCertificate"));
}

function readFile(path: string, option: string): Buffer {
  try {
    const bytes = readFileSync(path);
    if (bytes.length > 0) return bytes;
  } catch {
    // told below, like an empty file
  }
  throw invalid(join("options", option), `is '${path}', which cannot be read`);
}

function checkTogether(options: ConnectOptions, address: string): void {
  const { token = "", tlsCa, tlsCertificate, tlsKey, tlsServerName } = options;
  if (!tlsCertificate !== !tlsKey) throw invalid("options.tls_key", "and tls_certificate go together; only one is set");
  if (!tlsCa && (tlsCertificate || tlsServerName)) {
    throw invalid("options.tls_ca", "is not set; tls_certificate and tls_server_name need it");
  }
  if (token !== "" && !isVisible(token)) throw invalid("options.token", "has a character that is not visible ASCII");
  checkToken(options, address);
}

function checkToken({ token, tlsCa, allowInsecureToken }: ConnectOptions, address: string): void {
  if (!token || tlsCa || allowInsecureToken || isLocalAddress(address)) return;
  throw invalid("options.token", `is not sent to '${address}' in plain text; use TLS (tlsCa) or allowInsecureToken`);
}

/** Whether gRPC metadata can carry it. */
function isVisible(text: string): boolean {
  return /^[!-~]+$/.test(text);
}

/** Whether a gRPC address is on this host for certain: unix:..., localhost or a loopback IP. */
export function isLocalAddress(address: string): boolean {
  if (/^unix(-abstract)?:/.test(address)) return true;
  if (address.includes(",")) return false; // a list, whose others may be elsewhere
  const host = hostOf(address);
  if (isIP(host) === 4) return host.startsWith("127.");
  return host === "::1" || host === "localhost";
}

/** "[::1]:50051" to "::1", "dns:///localhost:50051" to "localhost". */
function hostOf(address: string): string {
  const rest = address.replace(/^(dns|ipv4|ipv6):\/*/, "");
  const bracketed = /^\[([^\]]*)\]/.exec(rest);
  if (bracketed) return bracketed[1];
  return isIP(rest) === 6 ? rest : rest.split(":")[0];
}

/** Calls `late` after so many seconds, unless what is returned is called before. */
export function onceLate(limitSeconds: number, late: () => void): () => void {
  const timer = setTimeout(late, Math.min(1000 * limitSeconds, 2 ** 31 - 1)); // longer ones would end at once
  return () => clearTimeout(timer);
}

/** That several calls, which are one to the caller, may take: throws (DEADLINE_EXCEEDED) once it has passed. */
export class Limit {
  readonly #until: number;

  constructor(readonly limitSeconds: number) {
    this.#until = performance.now() + 1000 * limitSeconds;
  }

  /** Seconds that are left, and `more`, but not more than one call may take. */
  left(more = 0): number {
    const left = (this.#until - performance.now()) / 1000 + more;
    if (left > 0) return Math.min(left, this.limitSeconds);
    const text = `the daemon did not send all pages within ${this.limitSeconds} s (deadlineSeconds)`;
    throw new CollidedError(Code.DEADLINE_EXCEEDED, text);
  }
}

type Reading = ClientReadableStream<unknown> | ClientDuplexStream<never, unknown>;

/** Resolves once a call has handed over its last message: with its error, or undefined if it ended well. */
export function endOf(call: Reading): Promise<CollidedError | undefined> {
  const read = new Promise<void>((resolve) => call.once("end", resolve));
  const status = new Promise<StatusObject>((resolve) => call.once("status", resolve));
  call.on("error", () => {}); // the status says the same
  return Promise.all([status, read]).then(([end]) => (end.code === Code.OK ? undefined : errorOfStatus(end)));
}
