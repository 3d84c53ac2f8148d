// Opens the page of collidectl view in a browser and tells what it shows, as one line of JSON.
// usage: node page.mjs TOOLS BROWSER ADDRESS FOLDER_FOR_PICTURES
import { createRequire } from "node:module";
import { join } from "node:path";

const [tools, executablePath, address, pictures] = process.argv.slice(2);
const puppeteer = createRequire(join(tools, "package.json"))("puppeteer-core");
const TIMEOUT = 60_000;

const browser = await puppeteer.launch({
  executablePath,
  // WebGL without a GPU; containers seldom allow a sandbox of Chromium's own.
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--disable-dev-shm-usage"],
});
const errors = [];
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(TIMEOUT);
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("request", (request) => request.url().startsWith("http") && !request.url().startsWith(address) && errors.push(`asks for ${request.url()}`));
  await page.setViewport({ width: 1280, height: 800 });
  await page.goto(address);

  const value = (id) => page.$eval(`#${id}`, (place) => Number(place.dataset.value));
  const text = (id) => page.$eval(`#${id}`, (place) => place.textContent);
  const until = (condition, ...values) => page.waitForFunction(condition, { timeout: TIMEOUT, polling: 50 }, ...values);
  const frameAfter = (frame) => until((last) => Number(document.getElementById("frame").dataset.value) > last, frame);
  // All of one frame.
  const shown = () =>
    page.evaluate(() => {
      const out = {};
      for (const id of ["frame", "contacts", "vertex_triangle", "edge_edge"]) out[id] = Number(document.getElementById(id).dataset.value);
      for (const id of ["contacts", "status-text"]) out[`${id} text`] = document.getElementById(id).textContent;
      return out;
    });
  // Colours of the canvas: how many there are, and how many pixels are drawn at all.
  const pixels = () =>
    page.$eval("#stage", (canvas) => {
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
      copy.drawImage(canvas, 0, 0);
      const data = new Uint32Array(copy.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
      return { colors: new Set(data).size, drawn: data.filter((pixel) => pixel >>> 24 > 0).length / data.length };
    });
  const picture = async (name, scheme) => {
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    await page.screenshot({ path: join(pictures, `${name}.png`) });
  };

  await frameAfter(0);
  await frameAfter(await value("frame"));
  const out = { name: await text("name"), facts: await text("facts"), live: await shown(), pixels: await pixels() };
  await picture("live", "light");

  await until(() => Number(document.getElementById("time").max) >= 5);
  await page.keyboard.press("Space");
  out.paused = await shown();
  await until(() => document.getElementById("position").textContent.includes("before the latest")); // others have come
  out.still_paused = await shown();
  await page.keyboard.press("ArrowLeft");
  out.one_back = await shown();
  await page.keyboard.press("Home");
  out.oldest = await shown();
  await page.keyboard.press("End");
  out.newest = await shown();
  await picture("paused", "dark");

  await page.click("#outlines");
  for (const box of await page.$$("#kinds input")) await box.evaluate((one) => one.click());
  for (const box of await page.$$("#meshes input")) await box.evaluate((one) => one.click());
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  out.nothing_visible = await pixels();

  await page.click("#pause");
  await frameAfter(out.paused.frame);
  out.again = await shown();
  console.log(JSON.stringify({ ...out, errors }));
  process.stdin.once("data", async () => {
    // Its daemon is gone.
    await until(() => document.getElementById("status").dataset.state === "waiting");
    await picture("waiting", "light");
    console.log(JSON.stringify({ status: await text("status-text"), errors }));
    // And so is collidectl; then another one is at its place.
    await until(() => document.getElementById("status").dataset.state === "lost");
    console.log(JSON.stringify({ status: await text("status-text") }));
    await until(() => document.getElementById("name").textContent === "reef_knot" && document.getElementById("status").dataset.state === "live");
    await frameAfter(0);
    console.log(JSON.stringify({ status: await text("status-text") }));
    await browser.close();
    process.exit(0);
  });
} catch (error) {
  console.log(JSON.stringify({ failed: error.stack, errors }));
  await browser.close();
  process.exit(1);
}
