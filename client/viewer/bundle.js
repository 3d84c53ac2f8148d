// Bundles the page into one file that loads nothing: node bundle.js FOLDER_OF_NODE_MODULES OUTPUT
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, renameSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const [tools, output] = process.argv.slice(2).map((path) => resolve(path));
const source = join(dirname(fileURLToPath(import.meta.url)), "src");
const { build } = createRequire(join(tools, "package.json"))("esbuild");

const bundled = await build({
  entryPoints: [join(source, "main.ts")],
  outdir: "out",
  bundle: true,
  minify: true,
  write: false,
  target: "es2022",
  format: "iife",
  legalComments: "inline",
  charset: "utf8",
  nodePaths: [join(tools, "node_modules")],
});
const text = (suffix) => bundled.outputFiles.find((file) => file.path.endsWith(suffix)).text;

// In HTML a script ends at its end tag, even in a string.
const script = text(".js").replaceAll("</script", "<\\/script");
const hash = createHash("sha256").update(script).digest("base64");
const policy = [
  "default-src 'none'",
  `script-src 'sha256-${hash}'`,
  "style-src 'unsafe-inline'",
  "connect-src 'self'",
  "img-src data: blob:",
  "base-uri 'none'",
  "form-action 'none'",
].join("; ");
const page = readFileSync(join(source, "page.html"), "utf8")
  .replace("<!-- policy -->", () => `<meta http-equiv="Content-Security-Policy" content="${policy}">`)
  .replace("<!-- style -->", () => `<style>${text(".css")}</style>`)
  .replace("<!-- script -->", () => `<script>${script}</script>`);

mkdirSync(dirname(output), { recursive: true });
writeFileSync(`${output}.new`, page);
renameSync(`${output}.new`, output);
