import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, test } from "node:test";
import { Code, type ConnectOptions, OwnDaemon, connect, findDaemon } from "../src/index.js";
import { TWO_TRIANGLES, fall, refused } from "./support.js";

const folder = mkdtempSync(join(tmpdir(), "connect-"));
after(() => rmSync(folder, { recursive: true }));
const file = (name: string) => join(folder, name);

function openssl(...words: string[]): void {
  const done = spawnSync("openssl", words, { cwd: folder, encoding: "utf8" });
  assert.equal(done.status, 0, done.stderr);
}

/** A certificate authority of its own, with a certificate for localhost and one for a client. */
function makeCertificates(): void {
  const curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"];
  openssl("req", "-x509", ...curve, "-keyout", "ca.key", "-out", "ca.pem", "-days", "2", "-subj", "/CN=authority");
  writeFileSync(file("names"), "subjectAltName=DNS:localhost,DNS:daemon.example");
  for (const name of ["localhost", "me"]) {
    openssl("req", ...curve, "-keyout", `${name}.key`, "-out", `${name}.csr`, "-subj", `/CN=${name}`);
    openssl(
      "x509",
      "-req",
      "-in",
      `${name}.csr`,
      "-CA",
      "ca.pem",
      "-CAkey",
      "ca.key",
      "-CAcreateserial",
      "-out",
      `${name}.pem`,
      "-days",
      "2",
      "-extfile",
      "names",
    );
  }
}

/** Serves a contact to these options, over a call and a stream. */
async function served(address: string, options: ConnectOptions): Promise<void> {
  const client = await connect(address, options);
  const scene = await client.createScene(TWO_TRIANGLES);
  const stream = await client.stream(scene);
  assert.equal((await stream.detect(fall(2))).vertexTriangle.count, 1);
  await stream.finish();
  await client.deleteScene(scene);
  await client.close();
}

test("TLS, a client certificate and a token get through, and nothing else does", async () => {
  makeCertificates();
  writeFileSync(file("tokens"), '[[tokens]]\nname = "a"\ntoken = "token-of-client-a"\n');
  const tls = [
    "--tls-certificate",
    file("localhost.pem"),
    "--tls-key",
    file("localhost.key"),
    "--tls-client-ca",
    file("ca.pem"),
  ];
  const daemon = await OwnDaemon.start(["--address", "127.0.0.1:0", "--tokens-file", file("tokens"), ...tls]);
  const port = daemon.addresses
    .find((address) => !address.startsWith("unix:"))!
    .split(":")
    .at(-1);
  const good = { tlsCa: file("ca.pem"), tlsCertificate: file("me.pem"), tlsKey: file("me.key"), token: "token-of-client-a" };
  await served(`localhost:${port}`, good);
  await served(`127.0.0.1:${port}`, { ...good, tlsServerName: "daemon.example" });
  await served(daemon.address, { token: "token-of-client-a" });
  await refused(() => connect(`localhost:${port}`, { ...good, token: "wrong" }), Code.UNAUTHENTICATED, "");
  const { tlsCertificate, tlsKey, ...withoutCertificate } = good;
  await refused(() => connect(`localhost:${port}`, { ...withoutCertificate, patienceSeconds: 0.3 }), Code.UNAVAILABLE, "");
  await refused(() => connect(`127.0.0.1:${port}`, { ...good, patienceSeconds: 0.3 }), Code.UNAVAILABLE, "", /127.0.0.1/);
  await refused(() => connect(`localhost:${port}`, { patienceSeconds: 0.3 }), Code.UNAVAILABLE, "");
  await daemon.stop();
});

test("options that cannot be are refused by name, and a token is not told to strangers", async () => {
  writeFileSync(file("empty"), "");
  const cases: [unknown, object, string, RegExp][] = [
    ["", {}, "address", /host:port or unix:/],
    [7, {}, "address", /host:port or unix:/],
    ["localhost:1", { timeout: 3 }, "options.timeout", /is not known/],
    ["localhost:1", { deadlineSeconds: -1 }, "options.deadline_seconds", /seconds from 0 to 2000000/],
    ["localhost:1", { tlsCa: file("none") }, "options.tls_ca", /cannot be read/],
    ["localhost:1", { tlsCa: file("empty") }, "options.tls_ca", /cannot be read/],
    ["localhost:1", { tlsServerName: "x" }, "options.tls_ca", /need it/],
    ["localhost:1", { tlsKey: "x" }, "options.tls_key", /only one is set/],
    ["localhost:1", { token: "a b" }, "options.token", /visible ASCII/],
    ["example.org:1", { token: "secret" }, "options.token", /plain text/],
    ["localhost.example.org:1", { token: "secret" }, "options.token", /plain text/],
    ["127.0.0.1.example.org:1", { token: "secret" }, "options.token", /plain text/],
    ["[2001:db8::1]:1", { token: "secret" }, "options.token", /plain text/],
    ["dns:///10.0.0.1:1", { token: "secret" }, "options.token", /plain text/],
    ["ipv4:127.0.0.1:1,10.0.0.1:1", { token: "secret" }, "options.token", /plain text/],
  ];
  for (const [address, options, field, message] of cases) {
    await refused(() => connect(address as string, options), Code.INVALID_ARGUMENT, field, message);
  }
  const local = ["unix:/none", "[::1]:1", "127.1.2.3:1", "dns:///localhost:1", "localhost:1"];
  for (const address of local) {
    await refused(() => connect(address, { token: "secret", patienceSeconds: 0 }), Code.UNAVAILABLE, "");
  }
});

test("nobody answers: the reason is told", async () => {
  await refused(
    () => connect(`unix:${file("no socket")}`, { patienceSeconds: 0.2 }),
    Code.UNAVAILABLE,
    "",
    /no daemon answers at unix:.*ENOENT/,
  );
});

test("the daemon's program is named, found on the PATH, or missed", async () => {
  const { COLLIDED_DAEMON, PATH } = process.env;
  try {
    assert.equal(findDaemon(), COLLIDED_DAEMON);
    process.env.COLLIDED_DAEMON = file("tokens");
    await refused(findDaemon, Code.NOT_FOUND, "", /COLLIDED_DAEMON is .*, which is not a program/);
    const open = () => readdirSync("/proc/self/fd").length;
    const before = open();
    await refused(() => OwnDaemon.start(), Code.NOT_FOUND, "");
    assert.equal(open(), before);
    delete process.env.COLLIDED_DAEMON;
    process.env.PATH = `${folder}:${COLLIDED_DAEMON!.replace(/\/[^/]*$/, "")}`;
    assert.equal(findDaemon(), COLLIDED_DAEMON);
    process.env.PATH = folder;
    await refused(() => connect(), Code.NOT_FOUND, "", /set COLLIDED_DAEMON/);
  } finally {
    Object.assign(process.env, { COLLIDED_DAEMON, PATH });
  }
  await refused(
    () => OwnDaemon.start(["--no-such-option"]),
    Code.UNAVAILABLE,
    "",
    /ended before it was ready: .*no-such-option/,
  );
});

test("a daemon of one's own takes its options from its caller alone", async () => {
  process.env.COLLIDED_LOG_FORMAT = "nonsense";
  try {
    await (await OwnDaemon.start()).stop();
  } finally {
    delete process.env.COLLIDED_LOG_FORMAT;
  }
});

test("a daemon of one's own ends with its client, even one that is killed", async () => {
  const program = `import { OwnDaemon } from ${JSON.stringify(new URL("../src/index.js", import.meta.url).href)};
    console.log((await OwnDaemon.start()).address); setInterval(() => {}, 1000);`;
  const child = spawn(process.execPath, ["--input-type=module", "-e", program], { stdio: ["ignore", "pipe", "inherit"] });
  const address = await new Promise<string>((resolve) => child.stdout.once("data", (text) => resolve(String(text).trim())));
  const alive = await connect(address);
  child.kill("SIGKILL");
  while ((await alive.getServerInfo().catch(() => undefined)) !== undefined)
    await new Promise((resolve) => setTimeout(resolve, 10));
  await alive.close();
  while (existsSync(address.replace(/^unix:|\/socket$/g, ""))) await new Promise((resolve) => setTimeout(resolve, 10));
});

test("a daemon that is older than --private is told of", async () => {
  const { COLLIDED_DAEMON } = process.env;
  writeFileSync(file("old"), "#!/bin/sh\necho The following argument was not expected: --private >&2; exit 2\n", { mode: 0o700 });
  try {
    process.env.COLLIDED_DAEMON = file("old");
    await refused(() => OwnDaemon.start(), Code.FAILED_PRECONDITION, "", /must be of release 0.2.0 or later, and .*old is older/);
  } finally {
    process.env.COLLIDED_DAEMON = COLLIDED_DAEMON;
  }
});
