// Between a client and a daemon: it cuts connections, keeps answers back, and leads to another daemon.

import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import { type Socket, connect, createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

export class Proxy {
  readonly #folder = mkdtempSync(join(tmpdir(), "proxy-"));
  readonly #sockets = new Set<Socket>();
  readonly #ofDaemons = new Set<Socket>();
  readonly #server = createServer((near) => {
    const far = connect(this.#path);
    this.#ofDaemons.add(far.on("close", () => this.#ofDaemons.delete(far)));
    for (const [socket, other] of [
      [near, far],
      [far, near],
    ]) {
      this.#sockets.add(socket);
      socket.on("error", () => {});
      socket.on("close", () => {
        this.#sockets.delete(socket);
        other.destroy();
      });
      socket.pipe(other);
    }
  });
  readonly address = `unix:${this.#folder}/socket`;
  #path = "";

  /** Listens. `address` is a daemon's Unix socket. */
  async open(address: string): Promise<void> {
    this.leadTo(address);
    await once(this.#server.listen(`${this.#folder}/socket`), "listening");
  }

  leadTo(address: string): void {
    this.#path = address.replace("unix:", "");
  }

  /** Keeps back what daemons answer from now on over the connections that are open. */
  mute(): void {
    for (const socket of this.#ofDaemons) socket.unpipe().resume();
  }

  /** Ends every connection, as if the network had gone. */
  cut(): void {
    for (const socket of this.#sockets) socket.destroy();
  }

  close(): void {
    this.#server.close();
    this.cut();
    rmSync(this.#folder, { recursive: true });
  }
}
