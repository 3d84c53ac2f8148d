// Where two features touch, in the frame that is shown.

type Point = [number, number, number];

const at = (positions: Float32Array, vertex: number): Point => [
  positions[3 * vertex],
  positions[3 * vertex + 1],
  positions[3 * vertex + 2],
];
const minus = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Point, b: Point): Point => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const clamp = (value: number): number => Math.min(1, Math.max(0, value));

/** Halfway between the closest points of the edges ab and cd (Ericson, Real-Time Collision Detection, 5.1.9). */
export function betweenEdges(positions: Float32Array, a: number, b: number, c: number, d: number): Point {
  const p = at(positions, a);
  const q = at(positions, c);
  const u = minus(at(positions, b), p);
  const v = minus(at(positions, d), q);
  const w = minus(p, q);
  const uu = dot(u, u);
  const vv = dot(v, v);
  const uv = dot(u, v);
  const uw = dot(u, w);
  const vw = dot(v, w);
  const area = uu * vv - uv * uv;
  let s = area > 1e-12 * uu * vv ? clamp((uv * vw - uw * vv) / area) : 0;
  let t = vv > 0 ? (uv * s + vw) / vv : 0;
  if (t < 0 || t > 1) {
    t = clamp(t);
    s = uu > 0 ? clamp((uv * t - uw) / uu) : 0;
  }
  return [0, 1, 2].map((i) => (p[i] + s * u[i] + q[i] + t * v[i]) / 2) as Point;
}

/** Where the edge ab goes through the plane of the triangle cde; the edge's middle where it lies in it. */
export function onEdge(positions: Float32Array, a: number, b: number, c: number, d: number, e: number): Point {
  const p = at(positions, a);
  const q = at(positions, b);
  const corner = at(positions, c);
  const normal = cross(minus(at(positions, d), corner), minus(at(positions, e), corner));
  const above = dot(normal, minus(p, corner));
  const below = dot(normal, minus(q, corner));
  const t = above === below ? 0.5 : clamp(above / (above - below));
  return [0, 1, 2].map((i) => p[i] + t * (q[i] - p[i])) as Point;
}

/** The middle of the corners, for contacts that have no closest points. */
export function middle(positions: Float32Array, vertices: Uint32Array): Point {
  const sum: Point = [0, 0, 0];
  for (const vertex of vertices) at(positions, vertex).forEach((value, i) => (sum[i] += value / vertices.length));
  return sum;
}

export const vertexAt = at;
