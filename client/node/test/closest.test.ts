import assert from "node:assert/strict";
import { test } from "node:test";
import { ContactFlag, ContactKind, EdgePlace, TrianglePlace, kept, placeOnTriangle, placesOnEdges } from "../src/index.js";
import { contactsOf } from "../src/contacts.js";
import { ContactChunk } from "../src/generated/collided/v1/contact.js";

const { CERTIFIED, COVERED } = ContactFlag;

function edges(count: number, arrays: Partial<ContactChunk>) {
  return contactsOf([ContactChunk.create({ kind: ContactKind.EDGE_EDGE, count, ...arrays })]).edgeEdge;
}

test("a byte of features says where the closest points are", () => {
  const places = [0, 1, 2, 3, 4, 5, 6].map((place) => placeOnTriangle(place + 32));
  const { FACE, SIDE_1, SIDE_2, SIDE_3, CORNER_1, CORNER_2, CORNER_3 } = TrianglePlace;
  assert.deepEqual(places, [FACE, SIDE_1, SIDE_2, SIDE_3, CORNER_1, CORNER_2, CORNER_3]);
  assert.deepEqual(placesOnEdges(16), [EdgePlace.INSIDE, EdgePlace.INSIDE]);
  assert.deepEqual(placesOnEdges(64 + 1 + 8), [EdgePlace.END_1, EdgePlace.END_2]);
  assert.deepEqual(placesOnEdges(2 + 4), [EdgePlace.END_2, EdgePlace.END_1]);
});

test("kept contacts are those that no other covers", () => {
  const flags = Uint8Array.of(CERTIFIED, CERTIFIED | COVERED, COVERED, 0);
  const contacts = edges(4, { flags, features: Uint8Array.of(0, 64, 16, 8) });
  assert.deepEqual(kept(contacts), [0, 3]);
  assert.deepEqual([...contacts].map(({ features }) => features), [0, 64, 16, 8]);
  assert.deepEqual(kept(edges(2, { features: Uint8Array.of(0, 64) })), [0, 1]);
  assert.throws(() => edges(2, { features: Uint8Array.of(0) }), /contacts.features has 1 bytes for 2 contacts; it needs 2/);
});
