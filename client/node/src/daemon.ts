// A daemon of one's own, on a Unix socket in a temporary folder.

import { type ChildProcessWithoutNullStreams, spawn } from "node:child_process";
import { accessSync, constants, statSync } from "node:fs";
import { delimiter, join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import { Code, CollidedError } from "./errors.js";

const READY_MS = 60_000;
const COMPILE_MS = 1_800_000; // a GPU's driver may have to compile the kernels
const STOP_MS = 10_000;
const POLL_MS = 5;

/** Where the daemon's program is: $COLLIDED_DAEMON, or `collided` on the PATH. Throws (NOT_FOUND) if there is none. */
export function findDaemon(): string {
  if (process.platform !== "linux")
    notFound(
      `the daemon runs on Linux, and this is ${process.platform}: ` +
        "run it in a container, in WSL or on a Linux host, and connect to its address",
    );
  const named = process.env.COLLIDED_DAEMON;
  if (named) return isProgram(named) ? named : notFound(`COLLIDED_DAEMON is '${named}', which is not a program`);
  const folders = (process.env.PATH ?? "").split(delimiter).filter((folder) => folder !== "");
  const found = folders.map((folder) => join(folder, "collided")).find(isProgram);
  return found ?? notFound("no daemon 'collided' is on the PATH; set COLLIDED_DAEMON, or connect to an address");
}

function notFound(message: string): never {
  throw new CollidedError(Code.NOT_FOUND, message);
}

function isProgram(path: string): boolean {
  try {
    accessSync(path, constants.X_OK);
    return statSync(path).isFile();
  } catch {
    return false;
  }
}

/** Ends with stop(), or with this process. */
export class OwnDaemon {
  /** All that it listens on, such as "127.0.0.1:40551" for the option --address 127.0.0.1:0. */
  addresses: readonly string[] = [];
  readonly #process: ChildProcessWithoutNullStreams;
  readonly #ended: Promise<void>; // once the process and its folder are gone
  #hasEnded = false;
  #said = "";

  private constructor(program: string, options: readonly string[]) {
    this.#process = spawn(program, ["--private", ...options]);
    this.#ended = new Promise((resolve) =>
      this.#process.once("close", () => {
        this.#hasEnded = true;
        resolve();
      }),
    );
    this.#process.on("error", (error) => (this.#said += error.message)); // told by #waitUntilReady
    for (const output of [this.#process.stdout, this.#process.stderr])
      output.setEncoding("utf8").on("data", (text: string) => (this.#said += text));
  }

  /** To connect to. */
  get address(): string {
    return this.addresses[0];
  }

  /**
   * Starts one and waits until it is ready. `options` are those of `collided`, such as ["--threads", "2"]; variables of the
   * environment, such as COLLIDED_THREADS, are none.
   */
  static async start(options: readonly string[] = []): Promise<OwnDaemon> {
    const program = findDaemon();
    const daemon = new OwnDaemon(program, options);
    try {
      daemon.addresses = await daemon.#waitUntilReady(program);
    } catch (error) {
      daemon.#process.kill("SIGKILL");
      await daemon.stop();
      throw error;
    }
    for (const output of [daemon.#process.stdout, daemon.#process.stderr]) output.removeAllListeners("data").resume();
    return daemon;
  }

  /** Stops it and removes its folder. */
  async stop(): Promise<void> {
    this.#process.stdin.destroy();
    const patience = new AbortController();
    const tooLong = pause(STOP_MS, "late", { signal: patience.signal }).catch(() => "aborted");
    if ((await Promise.race([this.#ended, tooLong])) === "late") this.#process.kill("SIGKILL");
    patience.abort();
    await this.#ended;
  }

  async #waitUntilReady(program: string): Promise<string[]> {
    const start = performance.now();
    for (;;) {
      const ready = /^ready (.+)\n/m.exec(this.#said);
      if (ready) return ready[1].split(",");
      if (this.#hasEnded) throw this.#failure(program);
      if (this.#isLate(performance.now() - start)) throw new CollidedError(Code.UNAVAILABLE, "the daemon was not ready in time");
      await pause(POLL_MS);
    }
  }

  /** A daemon that says that kernels are being compiled has more time. */
  #isLate(ms: number): boolean {
    return ms > READY_MS && (ms > COMPILE_MS || !this.#said.includes("compiling the kernels"));
  }

  #failure(program: string): CollidedError {
    if (/not expected: .*--private/.test(this.#said))
      return new CollidedError(Code.FAILED_PRECONDITION, `a private daemon must be of release 0.2.0 or later, and ${program} is older`);
    const lines = this.#said.split("\n").filter((line) => line !== "");
    return new CollidedError(Code.UNAVAILABLE, ["the daemon ended before it was ready", ...lines.slice(-2)].join(": "));
  }
}
