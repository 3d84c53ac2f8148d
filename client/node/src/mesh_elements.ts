// What a mesh of a living scene is made of.

import { join } from "./arrays.js";
import { Code, CollidedError } from "./errors.js";
import type { GetMeshResponse } from "./generated/collided/v1/collision_service.js";

/** A mesh of a scene. */
export interface MeshElements {
  /**
   * Three vertices of each element, numbered within the mesh, in the order of their scene-wide ids: triangles, then loose
   * edges as a b b, then loose points as a a a.
   */
  elements: Uint32Array;
  /** 0: it was removed. */
  vertexCount: number;
  /** The scene's editCount when this was so. */
  editCount: bigint;
}

type PageFrom = (firstElement: number) => Promise<GetMeshResponse>;

const TRIES = 8;
const ELEMENT_BYTES = 12;

/** The whole mesh; ABORTED if edits keep changing it between two pages. */
export async function readElements(pageFrom: PageFrom): Promise<MeshElements> {
  for (let tries = 0; tries < TRIES; ++tries) {
    const pages = await readPages(pageFrom);
    if (!pages) continue;
    const [{ vertexCount, editCount }] = pages;
    const elements = join(
      Uint32Array,
      pages.map((page) => page.elements),
    );
    const bad = elements.find((vertex) => vertex >= vertexCount);
    if (bad !== undefined) throw lost(`name vertex ${bad} of ${vertexCount}`);
    return { elements, vertexCount, editCount };
  }
  throw new CollidedError(Code.ABORTED, `the scene was edited while the mesh was read, ${TRIES} times`);
}

/** One page or more; undefined if the scene was edited between two of them. */
async function readPages(pageFrom: PageFrom): Promise<GetMeshResponse[] | undefined> {
  const pages = [await pageFrom(0)];
  const [{ elementCount, editCount }] = pages;
  for (let read = countOf(pages[0], 0); read < elementCount; ) {
    const page = await pageFrom(read).catch(hasFewer);
    if (page?.editCount !== editCount) return undefined;
    read += countOf(page, read);
    pages.push(page);
  }
  return pages;
}

/** What a page is refused with if the mesh has lost its elements since the last one. */
function hasFewer(error: CollidedError): undefined {
  if (error.field !== "first_element") throw error;
}

/** Elements of a page that comes after `before` of them. */
function countOf({ elements, elementCount }: GetMeshResponse, before: number): number {
  const count = elements.length / ELEMENT_BYTES;
  const isShort = count === 0 && before < elementCount;
  if (Number.isInteger(count) && before + count <= elementCount && !isShort) return count;
  throw lost(`has ${elements.length} bytes after ${before} of ${elementCount} elements`);
}

function lost(what: string): CollidedError {
  return new CollidedError(Code.DATA_LOSS, `elements ${what}`);
}
