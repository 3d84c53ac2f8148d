// The figures beside the scene.
import type { StageShare } from "./charts";
import { bytes, count, milliseconds, plain, words } from "./format";
import { drawn, found, KINDS, type KindFacts } from "./kinds";
import type { FrameMessage, SceneMessage } from "./messages";
import { OTHER_STAGES, stageMilliseconds } from "./stages";

export const element = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

const RATE_MS = 3000; // or the last two frames, if these are further apart
const SHAPES = ["disc", "diamond", "triangle", "square"];

/** Sets the text, and its number for programs that read the page. */
function set(id: string, text: string, value?: number | null): void {
  const place = element(id);
  if (place.textContent !== text) place.textContent = text;
  if (value !== undefined) place.dataset.value = String(value);
}

export class Panel {
  private stages: StageShare[] = [];
  private shown?: FrameMessage;
  private shownTimes: number[] = [];

  constructor(setKindVisible: (facts: KindFacts, isVisible: boolean) => void) {
    for (const facts of KINDS) {
      const row = legendRow(facts.label, `var(${facts.color})`, SHAPES[facts.shape], (is) => setKindVisible(facts, is));
      row.querySelector(".value")!.id = facts.kind;
      row.id = `row-${facts.kind}`;
      element("kinds").append(row);
    }
  }

  showScene(scene: SceneMessage, setMeshVisible: (index: number, isVisible: boolean) => void): void {
    const { vertices, triangles, device, mode, accuracy } = scene.scene;
    set("name", scene.name || `Scene ${scene.scene_id.slice(0, 8)}`);
    set("facts", `${count(triangles)} triangles · ${count(vertices)} vertices · ${mode.toUpperCase()} · ${accuracy} · ${device}`);
    element("facts").title = `Scene ${scene.scene_id}`;
    document.title = `${scene.name || scene.scene_id.slice(0, 8)} – collided viewer`;
    element("meshes").replaceChildren(
      ...scene.meshes
        .map((mesh, index) => ({ mesh, index }))
        .filter(({ mesh }) => mesh.vertices > 0)
        .map(({ mesh, index }) => {
          const color = `var(--mesh-${index % 6})`;
          const row = legendRow(mesh.name, color, "swatch", (is) => setMeshVisible(index, is));
          row.querySelector(".value")!.textContent = `${count(mesh.triangles)} △`;
          return row;
        }),
    );
    element("toi-label").parentElement!.dataset.mode = mode;
  }

  showFrame(frame: FrameMessage, scene: SceneMessage): void {
    const total = frame.contact_count;
    set("contacts", total === null ? (frame.any_contact ? "some" : "none") : count(total), total);
    set("total", milliseconds(frame.total_ms));
    set("frame", count(frame.frame), frame.frame);
    const toi = frame.advanced !== undefined ? `went ${plain(100 * frame.advanced)} % of the step` : earliest(frame, scene);
    set("toi", toi);
    set("memory", bytes(frame.device_bytes));
    for (const facts of KINDS) {
      const number = found(frame, facts.kind);
      set(facts.kind, number === null ? "–" : count(number), number);
      element(`row-${facts.kind}`).hidden = !facts.isCommon && !number;
    }
    this.shown = frame;
    this.showStageTimes();
    this.showNote(frame, scene);
  }

  /** Frames a second, as they are shown. */
  showRate(frame: FrameMessage): void {
    const now = performance.now();
    this.shownTimes = [...this.shownTimes, now].filter((time, i, all) => time > now - RATE_MS || i >= all.length - 2);
    const seconds = (now - this.shownTimes[0]) / 1000;
    const rate = seconds > 0 ? (this.shownTimes.length - 1) / seconds : 0;
    set("rate", `${plain(rate)} a second${frame.skipped_frames ? `, 1 of ${count(frame.skipped_frames + 1)}` : ""}`);
  }

  showStages(stages: StageShare[]): void {
    this.stages = stages;
    element("stages").replaceChildren(
      ...stages.map(({ name, color }) => {
        const row = document.createElement("div");
        row.append(mark(color, "swatch"), text("name", name === OTHER_STAGES ? "others" : words(name)), text("value", ""));
        row.querySelector(".value")!.id = `stage-${name}`;
        return row;
      }),
    );
    this.showStageTimes();
  }

  private showStageTimes(): void {
    const names = this.stages.map(({ name }) => name);
    for (const name of this.shown ? names : [])
      set(`stage-${name}`, milliseconds(stageMilliseconds(this.shown!, name, names)));
  }

  private showNote(frame: FrameMessage, scene: SceneMessage): void {
    const shown = KINDS.reduce((sum, facts) => sum + drawn(frame, facts), 0);
    const notes = [
      frame.contact_count && shown < frame.contact_count
        ? `${count(shown)} of ${count(frame.contact_count)} contacts are drawn.`
        : "",
      scene.vertex_stride > 1 ? `Coarsened: 1 in ${count(scene.vertex_stride)} vertices is drawn.` : "",
      frame.warnings.length ? `Warning: ${frame.warnings.map((name) => words(name.toLowerCase())).join(", ")}.` : "",
    ];
    element("note").textContent = notes.filter(Boolean).join(" ");
    element("note").hidden = !notes.some(Boolean);
  }
}

function earliest(frame: FrameMessage, scene: SceneMessage): string {
  if (scene.scene.mode === "dcd") return "– (DCD)";
  if (!frame.any_contact) return "none";
  return frame.earliest_toi === undefined ? "–" : `at ${plain(100 * frame.earliest_toi)} % of the step`;
}

function mark(color: string, shape: string): HTMLElement {
  const out = text("mark", "");
  out.classList.add(shape);
  out.style.setProperty("--color", color);
  return out;
}

function text(className: string, content: string): HTMLElement {
  const out = document.createElement("span");
  out.className = className;
  out.textContent = content;
  return out;
}

function legendRow(name: string, color: string, shape: string, setVisible: (isVisible: boolean) => void): HTMLElement {
  const row = document.createElement("label");
  const box = document.createElement("input");
  box.type = "checkbox";
  box.checked = true;
  box.addEventListener("change", () => setVisible(box.checked));
  row.append(box, mark(color, shape), text("name", name), text("value", ""));
  return row;
}
