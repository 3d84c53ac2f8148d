// The kinds of contacts: how each is named, marked and found in a frame.
import type { FrameMessage } from "./messages";

export type Kind = "vertex_triangle" | "edge_edge" | "triangle_triangle" | "edge_triangle";

export interface KindFacts {
  kind: Kind;
  label: string;
  /** The shape of its marks: 0 disc, 1 diamond, 2 triangle, 3 square. */
  shape: number;
  /** The custom property of its colour. */
  color: string;
  /** Vertices of one contact. */
  vertices: number;
  /** Pairs of these vertices that are drawn as lines. */
  lines: number[];
  /** It has a row even in scenes that do not ask for it. */
  isCommon: boolean;
}

export const KINDS: KindFacts[] = [
  { kind: "vertex_triangle", label: "Vertex–triangle", shape: 0, color: "--vt", vertices: 4, lines: [1, 2, 2, 3, 3, 1], isCommon: true },
  { kind: "edge_edge", label: "Edge–edge", shape: 1, color: "--ee", vertices: 4, lines: [0, 1, 2, 3], isCommon: true },
  {
    kind: "triangle_triangle", label: "Triangle–triangle", shape: 2, color: "--tt", vertices: 6,
    lines: [0, 1, 1, 2, 2, 0, 3, 4, 4, 5, 5, 3], isCommon: false,
  },
  {
    kind: "edge_triangle", label: "Edge through triangle", shape: 3, color: "--et", vertices: 5,
    lines: [0, 1, 2, 3, 3, 4, 4, 2], isCommon: false,
  },
];

/** Contacts that the daemon found; null where the scene asks only whether there are any. */
export const found = (frame: FrameMessage, kind: Kind): number | null => frame.counts[`contacts_${kind}`];

/** Contacts that are drawn. */
export const drawn = (frame: FrameMessage, facts: KindFacts): number => frame[facts.kind].length / facts.vertices;

/** The colours of the page's theme. */
export const themeColor = (property: string): string =>
  getComputedStyle(document.documentElement).getPropertyValue(property).trim();
