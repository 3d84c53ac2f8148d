// Reads on which features the closest points of a contact are, and which contacts others cover.

import type { Contacts } from "./contacts.js";
import { ContactFlag } from "./generated/collided/v1/contact.js";

/**
 * Lists the masks of a byte of `Contacts.features`. The closest points are p, of the first feature, and q, of the second.
 * NEARER_AT_FIRST says that the first surface comes clearly nearer beside p, NEARER_AT_SECOND that the second does beside q.
 * SAME_AS_BEFORE says that an earlier contact is between the same two features; vertex-triangle contacts come before edge-edge ones.
 *
 *     const isNearest = (contacts.features[i] & (ClosestFeature.NEARER_AT_SECOND | ClosestFeature.SAME_AS_BEFORE)) === 0;
 */
export enum ClosestFeature {
  NEARER_AT_FIRST = 16,
  NEARER_AT_SECOND = 32,
  SAME_AS_BEFORE = 64,
}

/**
 * Locates q on the triangle of a vertex and a triangle: within the face, on the side opposite to a corner, or on a corner. Corners
 * are counted from 1, in the order of the stencil. Ties go to the corner, then to the side.
 */
export enum TrianglePlace {
  FACE = 0,
  SIDE_1 = 1,
  SIDE_2 = 2,
  SIDE_3 = 3,
  CORNER_1 = 4,
  CORNER_2 = 5,
  CORNER_3 = 6,
}

/** Locates the closest point of an edge: within it, or on its first or second end in the stencil. Ties go to the end. */
export enum EdgePlace {
  INSIDE = 0,
  END_1 = 1,
  END_2 = 2,
}

/**
 * Reads a byte of `features` of vertex-triangle contacts.
 *
 *     if (placeOnTriangle(vertexTriangle.features[i]) === TrianglePlace.FACE) ...
 */
export function placeOnTriangle(features: number): TrianglePlace {
  return features & 7;
}

/**
 * Reads a byte of `features` of edge-edge contacts. Returns the places of p on the first edge and of q on the second.
 *
 *     const [p, q] = placesOnEdges(edgeEdge.features[i]);
 */
export function placesOnEdges(features: number): [EdgePlace, EdgePlace] {
  return [features & 3, (features >> 2) & 3];
}

/**
 * Returns the ascending indices of the contacts that no other one covers. They have each local minimum of distance between two
 * surfaces once. So all of them have one direction on a flat floor, which is what a rigid-body solver needs. Nothing is covered
 * unless the scene's `fields` name FEATURES and FLAGS, and its `kinds` VERTEX_TRIANGLE and EDGE_EDGE.
 *
 *     for (const i of kept(vertexTriangle)) push(vertexTriangle.distance[i], vertexTriangle.normals.subarray(3 * i, 3 * i + 3));
 */
export function kept({ count, flags }: Contacts): number[] {
  const indices = Array.from({ length: count }, (_, i) => i);
  return flags.length === 0 ? indices : indices.filter((i) => (flags[i] & ContactFlag.COVERED) === 0);
}
