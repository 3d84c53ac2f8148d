// The package as it runs on macOS and Windows, with a daemon elsewhere: process.platform is set before it is imported.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { text } from "node:stream/consumers";
import { test } from "node:test";
import { OwnDaemon } from "../src/index.js";

const PACKAGE = new URL("../src/index.js", import.meta.url).href;
const SUPPORT = new URL("./support.js", import.meta.url).href;

/** What the program says: two frames of a stream, and why it starts no daemon. */
const program = (address: string) => `
  const { Code, OwnDaemon, connect, findDaemon } = await import(${JSON.stringify(PACKAGE)});
  const { TWO_TRIANGLES, fall } = await import(${JSON.stringify(SUPPORT)});
  const client = await connect(${JSON.stringify(address)});
  const stream = await client.stream(await client.createScene(TWO_TRIANGLES), { window: 2 });
  for (const depth of [0.5, 2]) console.log(...(await stream.detect(fall(depth))).vertexTriangle.toi.map((t) => +t.toFixed(9)));
  await stream.finish();
  await client.close();
  for (const call of [findDaemon, OwnDaemon.start, connect])
    await Promise.resolve().then(call).catch((error) => console.log(Code[error.code], error.message));`;

for (const system of ["darwin", "win32"]) {
  test(`streams go to a daemon elsewhere on ${system}, and none is started there`, async () => {
    const daemon = await OwnDaemon.start(["--threads", "1", "--address", "127.0.0.1:0"]);
    try {
      const address = daemon.addresses.find((place) => place.startsWith("127.0.0.1:"));
      assert(address);
      const patched = `Object.defineProperty(process, "platform", { value: ${JSON.stringify(system)} });${program(address)}`;
      const child = spawn(process.execPath, ["--input-type=module", "--eval", patched]);
      const [said, complaints] = await Promise.all([text(child.stdout), text(child.stderr), once(child, "close")]);
      const advice =
        `NOT_FOUND the daemon runs on Linux, and this is ${system}: ` +
        "run it in a container, in WSL or on a Linux host, and connect to its address";
      assert.equal(said, `\n0.5\n${`${advice}\n`.repeat(3)}`, complaints);
    } finally {
      await daemon.stop();
    }
  });
}
