// Makes src/generated from the .proto files, with protoc (Debian: protobuf-compiler) and ts-proto.

import { spawnSync } from "node:child_process";
import { mkdirSync, rmSync } from "node:fs";
import { fileURLToPath } from "node:url";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const options = [
  "esModuleInterop=true",
  "importSuffix=.js",
  "forceLong=bigint", // past 2^53 a number loses digits
  "oneof=unions-value",
  "removeEnumPrefix=true",
  "unrecognizedEnum=false",
  "outputServices=generic-definitions",
  "outputJsonMethods=false",
  "outputIndex=false",
];
const proto = here("../../proto");
const files = ["collision_service", "error_details"].map((name) => `${proto}/collided/v1/${name}.proto`);

rmSync(here("src/generated"), { recursive: true, force: true });
mkdirSync(here("src/generated"));
const made = spawnSync(
  "protoc",
  [
    `--plugin=${here("node_modules/.bin/protoc-gen-ts_proto")}`,
    `--ts_proto_out=${here("src/generated")}`,
    `--ts_proto_opt=${options.join(",")}`,
    `-I${proto}`,
    ...files,
  ],
  { stdio: "inherit" },
);
if (made.error) console.error(`protoc cannot be run (Debian: protobuf-compiler): ${made.error.message}`);
process.exit(made.status ?? 1);
