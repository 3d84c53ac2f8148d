// The page: what comes from collidectl goes to the stage, the panel and the charts; keys and buttons to these.
import "./style.css";
import { Charts } from "./charts";
import { Connection } from "./connection";
import { count } from "./format";
import { History } from "./history";
import type { FrameMessage, Message, SceneMessage } from "./messages";
import { element, Panel } from "./panel";
import { Stage } from "./stage";
import { bindKeys } from "./keys";

const stage = new Stage(element<HTMLCanvasElement>("stage"));
const panel = new Panel((facts, isVisible) => {
  stage.contacts.setVisible(facts, isVisible);
  stage.draw();
});
const charts = new Charts(element("contact-chart"), element("stage-chart"), (stages) => panel.showStages(stages));
const history = new History();
const slider = element<HTMLInputElement>("time");

let scene: SceneMessage | undefined;
let latest: FrameMessage | undefined;
let isPaused = false;
let status = { state: "connecting", message: "Connecting…" };

const LOST = "collidectl does not answer; trying again. If it was started anew, open the address that it printed.";

function showStatus(): void {
  const isLive = status.state === "live";
  const waits = isLive && !latest;
  element("status").dataset.state = isLive && isPaused ? "paused" : waits ? "waiting" : status.state;
  document.body.classList.toggle("stale", !isLive);
  element("status-text").textContent = isLive ? (isPaused ? "Paused" : waits ? "Waiting for a frame" : "Live") : status.message;
  element("empty").hidden = latest !== undefined;
  element("empty").textContent = isLive ? "The scene is there. Its first frame will appear here." : status.message;
}

function show(frame: FrameMessage): void {
  if (!scene) return;
  stage.showFrame(frame);
  panel.showFrame(frame, scene);
}

function showPosition(): void {
  slider.max = String(Math.max(0, history.length - 1));
  slider.disabled = !isPaused || history.length < 2;
  if (!isPaused) slider.value = slider.max;
  const at = history.at(Number(slider.value));
  const before = latest && at ? latest.frame - at.frame : 0;
  element("position").textContent = !at
    ? ""
    : isPaused
      ? `frame ${count(at.frame)}${before ? `, ${count(before)} before the latest` : ""}`
      : `last ${count(history.length)} frames kept`;
}

function takeScene(message: SceneMessage): void {
  const isSame = scene?.scene_id === message.scene_id;
  scene = message;
  latest = undefined;
  history.clear(); // earlier frames are of other triangles
  if (!isSame) charts.clear();
  setPaused(false);
  stage.showScene(message, isSame);
  panel.showScene(message, (index, isVisible) => {
    stage.surfaces.setVisible(index, isVisible);
    stage.draw();
  });
}

function takeFrame(frame: FrameMessage): void {
  if (frame.epoch !== scene?.epoch) return;
  latest = frame;
  charts.add(frame);
  panel.showRate(frame);
  if (isPaused) return showPosition();
  history.add(frame);
  show(frame);
  showPosition();
}

function take(message: Message): void {
  if (message.kind === "scene") takeScene(message);
  else if (message.kind === "frame") takeFrame(message);
  else status = message;
  showStatus();
}

function setPaused(pause: boolean): void {
  isPaused = pause;
  element("pause").textContent = pause ? "Go on" : "Pause";
  element("pause").setAttribute("aria-pressed", String(pause));
  if (!pause && latest && history.length) {
    if (history.at(history.length - 1) !== latest) history.add(latest);
    show(latest);
  }
  showPosition();
  showStatus();
}

/** Shows a kept frame; those beyond the first and the last are these. */
function goTo(index: number): void {
  if (!history.length) return;
  if (!isPaused) setPaused(true);
  slider.value = String(index);
  show(history.at(Number(slider.value))!);
  showPosition();
}

function toggle(id: string, apply: (is: boolean) => void): () => void {
  const box = element<HTMLInputElement>(id);
  box.addEventListener("change", () => {
    apply(box.checked);
    stage.draw();
  });
  return () => box.click();
}

const toggleOutlines = toggle("outlines", (is) => stage.contacts.setFeatures(is));
const toggleWireframe = toggle("wireframe", (is) => stage.surfaces.setWireframe(is));

let up: "y" | "z" = "z";
function changeUp(): void {
  up = up === "z" ? "y" : "z";
  element("up").textContent = `${up.toUpperCase()} up`;
  stage.setUp(up);
}

element("pause").addEventListener("click", () => setPaused(!isPaused));
element("fit").addEventListener("click", () => stage.fit());
element("up").addEventListener("click", changeUp);
slider.addEventListener("input", () => goTo(Number(slider.value)));
bindKeys({
  " ": () => setPaused(!isPaused),
  ArrowLeft: () => goTo(Number(slider.value) - 1),
  ArrowRight: () => goTo(Number(slider.value) + 1),
  Home: () => goTo(0),
  End: () => goTo(history.length - 1),
  "shift+ArrowLeft": () => stage.turn(1, 0),
  "shift+ArrowRight": () => stage.turn(-1, 0),
  "shift+ArrowUp": () => stage.turn(0, 1),
  "shift+ArrowDown": () => stage.turn(0, -1),
  "+": () => stage.zoom(1),
  "-": () => stage.zoom(-1),
  f: () => stage.fit(),
  o: toggleOutlines,
  w: toggleWireframe,
  u: changeUp,
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  stage.useTheme();
  charts.useTheme();
});
new Connection(take, () => {
  if (status.state !== "ended") status = { state: "lost", message: LOST };
  showStatus();
});
