// What collidectl sends: client/cli/web/messages.hpp describes it.

export interface Mesh {
  name: string;
  motion: string;
  first: number;
  vertices: number;
  triangles: number;
}

export interface SceneFacts {
  vertices: number;
  triangles: number;
  device: string;
  mode: string;
  accuracy: string;
  report: string;
}

export interface SceneMessage {
  kind: "scene";
  epoch: number;
  scene_id: string;
  name: string;
  scene: SceneFacts;
  meshes: Mesh[];
  vertex_stride: number;
  triangles: Uint32Array;
  edges: Uint32Array;
  points: Uint32Array;
}

export interface FrameMessage {
  kind: "frame";
  epoch: number;
  frame: number;
  skipped_frames: number;
  omitted_contacts: number;
  contact_count: number | null;
  any_contact: boolean;
  earliest_toi?: number;
  advanced?: number;
  total_ms: number;
  queue_ms: number;
  stage_ms: Record<string, number>;
  engine: string;
  counts: Record<string, number | null>;
  device_bytes: number;
  warnings: string[];
  positions: Float32Array;
  vertex_triangle: Uint32Array;
  edge_edge: Uint32Array;
  triangle_triangle: Uint32Array;
  edge_triangle: Uint32Array;
  bytes: number;
}

export interface StatusMessage {
  kind: "status";
  state: "live" | "waiting" | "ended";
  message: string;
}

export type Message = SceneMessage | FrameMessage | StatusMessage;

const KINDS = ["", "scene", "frame", "status"];

/** Throws for a message that is cut off or of an unknown kind. */
export function decode(buffer: ArrayBuffer): Message {
  const [kind, jsonBytes] = new Uint32Array(buffer, 0, 2);
  const name = KINDS[kind];
  if (!name) throw new Error(`message of kind ${kind}`);
  const { arrays, ...json } = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, jsonBytes)));
  let offset = 8 + jsonBytes;
  for (const [array, length] of Object.entries(arrays as Record<string, number>)) {
    json[array] = array === "positions" ? new Float32Array(buffer, offset, length) : new Uint32Array(buffer, offset, length);
    offset += 4 * length;
  }
  return { ...json, kind: name, bytes: buffer.byteLength } as Message;
}
