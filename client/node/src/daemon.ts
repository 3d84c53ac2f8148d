// A daemon of one's own, on a Unix socket in a temporary folder.

import { type ChildProcess, spawn } from "node:child_process";
import { once } from "node:events";
import { accessSync, constants, mkdtempSync, openSync, closeSync, readFileSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { delimiter, join } from "node:path";
import { setTimeout as pause } from "node:timers/promises";
import { Code, CollidedError } from "./errors.js";

/** Its only client may use everything. */
const OWN = [
  "--max-scenes-per-client",
  "--max-streams-per-client",
  "--max-device-mb-per-client",
  "--max-frame-seconds",
].flatMap((limit) => [limit, "1000000"]);
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
  return onPath("collided") ?? notFound("no daemon 'collided' is on the PATH; set COLLIDED_DAEMON, or connect to an address");
}

/** A command that runs another one, and stops it when this process is gone. */
function endingWithParent(): string[] {
  const setpriv = process.platform === "linux" && onPath("setpriv");
  return setpriv ? [setpriv, "--pdeathsig", "TERM"] : [];
}

/** Without options of daemons that others start. */
function ownEnvironment(): NodeJS.ProcessEnv {
  return Object.fromEntries(Object.entries(process.env).filter(([name]) => !name.startsWith("COLLIDED_")));
}

function onPath(name: string): string | undefined {
  const places = (process.env.PATH ?? "").split(delimiter).filter((folder) => folder !== "");
  return places.map((folder) => join(folder, name)).find(isProgram);
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

/** Ends with stop(), or with this process; if that is killed, on Linux where `setpriv` (util-linux) is installed. */
export class OwnDaemon {
  /** To connect to. */
  readonly address: string;
  /** All that it listens on, such as "127.0.0.1:40551" for the option --address 127.0.0.1:0. */
  addresses: readonly string[] = [];
  readonly #folder: string;
  readonly #process: ChildProcess;
  readonly #stopAtExit = () => this.#kill();

  private constructor(daemon: string, folder: string, options: readonly string[]) {
    this.#folder = folder;
    this.address = `unix:${folder}/socket`;
    const words = ["--address", this.address, "--ready-file", join(folder, "ready"), "--log-level", "warning", ...OWN];
    const [program, ...rest] = [...endingWithParent(), daemon, ...words, ...options];
    const log = openSync(join(folder, "log"), "a", 0o600);
    try {
      this.#process = spawn(program, rest, { stdio: ["ignore", log, log], env: ownEnvironment() });
    } finally {
      closeSync(log);
    }
    this.#process.on("error", () => {}); // told by #waitUntilReady
    process.once("exit", this.#stopAtExit);
  }

  /**
   * Starts one and waits until it is ready. `options` are those of `collided`, such as ["--threads", "2"]; variables of the
   * environment, such as COLLIDED_THREADS, are none.
   */
  static async start(options: readonly string[] = []): Promise<OwnDaemon> {
    const program = findDaemon();
    const folder = mkdtempSync(join(tmpdir().length > 80 ? "/tmp" : tmpdir(), "collided-")); // a socket's path has 107 bytes
    let daemon: OwnDaemon | undefined;
    try {
      daemon = new OwnDaemon(program, folder, options);
      await daemon.#waitUntilReady();
      daemon.addresses = readFileSync(join(folder, "ready"), "utf8").trim().split("\n");
      return daemon;
    } catch (error) {
      await daemon?.stop();
      rmSync(folder, { recursive: true, force: true });
      throw error;
    }
  }

  /** Stops it and removes its folder. */
  async stop(): Promise<void> {
    process.off("exit", this.#stopAtExit);
    this.#process.kill("SIGTERM");
    const isOver = this.#hasEnded ? Promise.resolve() : once(this.#process, "exit");
    const patience = new AbortController();
    const tooLong = pause(STOP_MS, "late", { signal: patience.signal }).catch(() => "aborted");
    if ((await Promise.race([isOver, tooLong])) === "late") this.#process.kill("SIGKILL");
    patience.abort();
    await isOver;
    rmSync(this.#folder, { recursive: true, force: true });
  }

  get #hasEnded(): boolean {
    return this.#process.pid === undefined || this.#process.exitCode !== null || this.#process.signalCode !== null;
  }

  async #waitUntilReady(): Promise<void> {
    const start = performance.now();
    while (!statSync(join(this.#folder, "ready"), { throwIfNoEntry: false })?.size) {
      if (this.#hasEnded) throw new CollidedError(Code.UNAVAILABLE, `the daemon ended before it was ready${this.#lastWords()}`);
      if (this.#isLate(performance.now() - start)) throw new CollidedError(Code.UNAVAILABLE, "the daemon was not ready in time");
      await pause(POLL_MS);
    }
  }

  /** A daemon that says that kernels are being compiled has more time. */
  #isLate(ms: number): boolean {
    return ms > READY_MS && (ms > COMPILE_MS || !this.#log().includes("compiling the kernels"));
  }

  #log(): string {
    return readFileSync(join(this.#folder, "log"), "utf8");
  }

  #lastWords(): string {
    const lines = this.#log().split("\n");
    return lines
      .filter((line) => line !== "")
      .slice(-2)
      .map((line) => `: ${line}`)
      .join("");
  }

  #kill(): void {
    this.#process.kill("SIGKILL");
    rmSync(this.#folder, { recursive: true, force: true });
  }
}
