// The last minute: contacts of each kind as lines, times of the stages on top of each other.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { axis } from "./format";
import { found, KINDS, themeColor } from "./kinds";
import type { FrameMessage } from "./messages";
import { OTHER_STAGES, stageMilliseconds } from "./stages";

const SECONDS = 60;
const HEIGHT = 120;
const MAX_STAGES = 5;
const REDRAW_MS = 200;

interface Sample {
  time: number;
  contacts: (number | null)[];
  stages: Record<string, number>;
}

export interface StageShare {
  name: string;
  color: string;
}

export class Charts {
  private samples: Sample[] = [];
  private contactPlot?: uPlot;
  private stagePlot?: uPlot;
  private stages: string[] = [];
  private isDue = false;

  constructor(
    private readonly contactPlace: HTMLElement,
    private readonly stagePlace: HTMLElement,
    private readonly showLegend: (stages: StageShare[]) => void,
  ) {
    this.useTheme();
    setInterval(() => this.draw(), 1000);
    new ResizeObserver(() => this.resize()).observe(contactPlace);
  }

  add(frame: FrameMessage): void {
    this.samples.push({
      time: performance.now() / 1000,
      contacts: KINDS.map(({ kind }) => found(frame, kind)),
      stages: frame.stage_ms,
    });
    if (this.isDue) return;
    this.isDue = true;
    setTimeout(() => {
      this.isDue = false;
      this.draw();
    }, REDRAW_MS);
  }

  clear(): void {
    this.samples = [];
    this.stages = [];
    this.draw();
  }

  useTheme(): void {
    this.contactPlot?.destroy();
    this.contactPlot = new uPlot(
      options(this.contactPlace, KINDS.map(({ color }) => ({ stroke: themeColor(color), width: 1.5 })), largest),
      [[], ...KINDS.map(() => [])],
      this.contactPlace,
    );
    this.makeStagePlot();
    this.draw();
  }

  private makeStagePlot(): void {
    const colors = this.stages.map((name, index) => stageColor(name, index));
    this.stagePlot?.destroy();
    // The sums are drawn from the largest down; each hides what is below it but its own band.
    const series = colors.map((color) => ({ stroke: color, fill: color, width: 0 }));
    this.stagePlot = new uPlot(options(this.stagePlace, series, usualMaximum), [[], ...series.map(() => [])], this.stagePlace);
    this.showLegend(this.stages.map((name, index) => ({ name, color: colors[index] })));
  }

  private draw(): void {
    const now = performance.now() / 1000;
    this.samples = this.samples.filter(({ time }) => time > now - SECONDS);
    const times = this.samples.map(({ time }) => time - now);
    this.contactPlot!.setData([times, ...KINDS.map((_, kind) => this.contacts(kind))]);
    this.chooseStages();
    this.stagePlot!.setData([times, ...this.sums()]);
  }

  /** No line for a kind that the scene does not have. */
  private contacts(kind: number): (number | null)[] {
    const has = kind < 2 || this.samples.some(({ contacts }) => contacts[kind]);
    return this.samples.map(({ contacts }) => (has ? contacts[kind] : null));
  }

  /** The stages that take longest get a band each; the choice changes only if others have come to take longer by far. */
  private chooseStages(): void {
    const totals: Record<string, number> = {};
    for (const { stages } of this.samples)
      for (const [name, ms] of Object.entries(stages)) totals[name] = (totals[name] ?? 0) + ms;
    const wanted = Object.keys(totals).sort((a, b) => totals[b] - totals[a]).slice(0, MAX_STAGES);
    const least = Math.min(...this.stages.filter((name) => name !== OTHER_STAGES).map((name) => totals[name] ?? 0));
    const isStale = wanted.some((name) => !this.stages.includes(name) && totals[name] > 1.5 * least);
    if (!this.samples.length || (this.stages.length > wanted.length && !isStale)) return;
    this.stages = [...wanted, OTHER_STAGES];
    this.makeStagePlot();
  }

  /** Of each band the sum of it and those after it, for the first to be drawn first. */
  private sums(): number[][] {
    const rows = this.samples.map(({ stages }) => {
      const of = this.stages.map((name) => stageMilliseconds({ stage_ms: stages }, name, this.stages));
      for (let i = of.length - 2; i >= 0; --i) of[i] += of[i + 1];
      return of;
    });
    return this.stages.map((_, index) => rows.map((row) => row[index]));
  }

  private resize(): void {
    this.contactPlot?.setSize({ width: this.contactPlace.clientWidth, height: HEIGHT });
    this.stagePlot?.setSize({ width: this.stagePlace.clientWidth, height: HEIGHT });
  }
}

const stageColor = (name: string, index: number): string =>
  themeColor(name === OTHER_STAGES ? "--stage-5" : `--stage-${index}`);

/** Without the few largest values, next to which all others would be flat. */
function usualMaximum(values: number[]): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.ceil(0.98 * sorted.length))] ?? 0;
}

const largest = (values: (number | null)[]): number => values.reduce((most: number, value) => Math.max(most, value ?? 0), 0);

/** `maximum`: of the values of a series, as far as it matters for the scale. */
function options(place: HTMLElement, series: uPlot.Series[], maximum: (values: number[]) => number): uPlot.Options {
  const grid = { stroke: themeColor("--line"), width: 1 };
  const shared = { stroke: themeColor("--soft"), font: "11px system-ui, sans-serif", grid, ticks: { show: false } };
  return {
    width: place.clientWidth || 280,
    height: HEIGHT,
    cursor: { show: false },
    legend: { show: false },
    padding: [8, 18, 0, 0],
    scales: {
      x: { time: false, range: [-SECONDS, 0] },
      y: { range: (plot) => [0, 1.15 * Math.max(...plot.data.slice(1).map((values) => maximum(values as number[]))) || 1] },
    },
    axes: [
      { ...shared, size: 22, splits: () => [-60, -40, -20, 0], values: (_, at) => at.map((s) => (s ? `−${-s} s` : "now")) },
      { ...shared, size: 46, values: (_, at) => at.map((value) => axis(value)) },
    ],
    series: [{}, ...series.map((one) => ({ points: { show: false }, ...one }))],
  };
}
