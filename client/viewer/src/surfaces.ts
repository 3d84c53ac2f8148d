// The meshes of a scene: one array of positions, of which each mesh draws its own triangles.
import * as THREE from "three";
import { themeColor } from "./kinds";
import type { FrameMessage, SceneMessage } from "./messages";
import { addNormals } from "./normals";

const PALETTE = 6; // --mesh-0 and so on
const FEW_TRIANGLES = 2000; // below, facets show what the scene is made of; above, they only look rough

export class Surfaces {
  private readonly group = new THREE.Group();
  private meshes: THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>[] = [];
  private position = new THREE.BufferAttribute(new Float32Array(), 3);
  private normal = new THREE.BufferAttribute(new Float32Array(), 3);
  private triangles: Uint32Array = new Uint32Array();
  private readonly lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial());
  private readonly points = new THREE.Points(
    new THREE.BufferGeometry(),
    new THREE.PointsMaterial({ size: 3, sizeAttenuation: false }),
  );
  private isWireframe = false;

  constructor(scene: THREE.Scene) {
    this.lines.frustumCulled = this.points.frustumCulled = false;
    this.group.add(this.lines, this.points);
    this.group.visible = false;
    scene.add(this.group);
  }

  useTheme(): void {
    this.meshes.forEach((mesh, index) => mesh.material.color.set(meshColor(index)));
    this.lines.material.color.set(meshColor(0));
    this.points.material.color.set(meshColor(0));
  }

  showScene(scene: SceneMessage): void {
    for (const mesh of this.meshes) {
      this.group.remove(mesh);
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
    this.group.visible = false; // until there are positions
    const vertices = scene.meshes.reduce((sum, mesh) => sum + mesh.vertices, 0);
    this.position = dynamic(vertices);
    this.normal = dynamic(vertices);
    this.triangles = scene.triangles;
    let first = 0;
    this.meshes = scene.meshes.map((mesh) => {
      const indices = scene.triangles.subarray(3 * first, 3 * (first += mesh.triangles));
      return this.makeMesh(indices);
    });
    if (this.meshes.length) this.group.add(...this.meshes);
    this.replaceGeometry(this.lines, scene.edges);
    this.replaceGeometry(this.points, scene.points);
    this.useTheme();
  }

  showFrame(frame: FrameMessage): void {
    if (frame.positions.length !== this.position.array.length) return;
    (this.position.array as Float32Array).set(frame.positions);
    this.position.needsUpdate = true;
    addNormals(frame.positions, this.triangles, this.normal.array as Float32Array);
    this.normal.needsUpdate = true;
    this.group.visible = true;
  }

  setVisible(index: number, isVisible: boolean): void {
    const mesh = this.meshes[index];
    if (mesh) mesh.visible = isVisible;
  }

  setWireframe(isWireframe: boolean): void {
    this.isWireframe = isWireframe;
    for (const mesh of this.meshes) mesh.material.wireframe = isWireframe;
  }

  boundingSphere(): THREE.Sphere | null {
    if (this.position.count === 0) return null;
    const geometry = new THREE.BufferGeometry().setAttribute("position", this.position);
    geometry.computeBoundingSphere();
    return geometry.boundingSphere;
  }

  private makeMesh(indices: Uint32Array): THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial> {
    const geometry = this.makeGeometry(indices);
    geometry.setAttribute("normal", this.normal);
    const material = new THREE.MeshStandardMaterial({
      roughness: 0.82,
      metalness: 0,
      side: THREE.DoubleSide,
      flatShading: indices.length < 3 * FEW_TRIANGLES,
      wireframe: this.isWireframe,
      polygonOffset: true, // lines of contacts lie in the surface
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    return mesh;
  }

  private makeGeometry(indices: Uint32Array): THREE.BufferGeometry {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", this.position);
    geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    return geometry;
  }

  private replaceGeometry(object: THREE.LineSegments | THREE.Points, indices: Uint32Array): void {
    object.geometry.dispose();
    object.geometry = this.makeGeometry(indices);
  }
}

export const meshColor = (index: number): string => themeColor(`--mesh-${index % PALETTE}`);

function dynamic(vertices: number): THREE.BufferAttribute {
  return new THREE.BufferAttribute(new Float32Array(3 * vertices), 3).setUsage(THREE.DynamicDrawUsage);
}
