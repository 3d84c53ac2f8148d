// Times of stages, of which a few have a band of their own in the chart.
import type { FrameMessage } from "./messages";

export const OTHER_STAGES = "other";

/** Milliseconds of a stage, or with OTHER_STAGES of those that are not named. */
export function stageMilliseconds({ stage_ms }: Pick<FrameMessage, "stage_ms">, name: string, named: string[]): number {
  if (name !== OTHER_STAGES) return stage_ms[name] ?? 0;
  return Object.entries(stage_ms).reduce((sum, [stage, ms]) => (named.includes(stage) ? sum : sum + ms), 0);
}
