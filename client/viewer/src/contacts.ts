// Contacts: a mark where each is, and the two features that touch. What is hidden by a surface shines through faintly.
import * as THREE from "three";
import { betweenEdges, middle, onEdge, vertexAt } from "./closest";
import { drawn, KINDS, themeColor, type KindFacts } from "./kinds";
import type { FrameMessage } from "./messages";

const VERTEX_SHADER = `
  uniform float size;
  void main() {
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_Position.z -= 0.0005 * gl_Position.w;  // in front of the surface that it lies in
    gl_PointSize = size;
  }`;

// A disc, a diamond, a triangle or a square with a rim.
const FRAGMENT_SHADER = `
  uniform vec3 color, rim;
  uniform float opacity, size;
  uniform int shape;
  void main() {
    vec2 p = 2.0 * gl_PointCoord - 1.0;
    float d = shape == 0 ? length(p) : shape == 1 ? abs(p.x) + abs(p.y) :
        shape == 2 ? max(1.5 * abs(p.x) - 0.75 * p.y, p.y) + 0.25 : max(abs(p.x), abs(p.y)) + 0.2;
    float soft = 2.0 / size;
    float inside = 1.0 - smoothstep(1.0 - soft, 1.0, d);
    if (inside <= 0.0) discard;
    gl_FragColor = vec4(mix(color, rim, smoothstep(0.62 - soft, 0.62 + soft, d)), inside * opacity);
    #include <colorspace_fragment>
  }`;

interface Marks {
  facts: KindFacts;
  objects: THREE.Object3D[];
  points: THREE.ShaderMaterial[];
  lines: THREE.LineBasicMaterial[];
  pointGeometry: THREE.BufferGeometry;
  lineGeometry: THREE.BufferGeometry;
  isVisible: boolean;
}

export class Contacts {
  private readonly marks: Marks[];
  private pixelRatio = 1;
  private hasFeatures = true;

  constructor(scene: THREE.Scene) {
    this.marks = KINDS.map((facts) => makeMarks(facts));
    for (const marks of this.marks) scene.add(...marks.objects);
  }

  useTheme(): void {
    for (const { facts, points, lines } of this.marks) {
      for (const material of points) {
        material.uniforms.color.value.set(themeColor(facts.color));
        material.uniforms.rim.value.set(themeColor("--rim"));
      }
      for (const material of lines) material.color.set(themeColor(facts.color));
    }
  }

  clear(): void {
    for (const marks of this.marks) {
      setPositions(marks.pointGeometry, new Float32Array());
      setPositions(marks.lineGeometry, new Float32Array());
    }
  }

  showFrame(frame: FrameMessage): void {
    const most = Math.max(...KINDS.map((facts) => drawn(frame, facts)));
    for (const marks of this.marks) {
      setPositions(marks.pointGeometry, pointsOf(frame, marks.facts));
      setPositions(marks.lineGeometry, linesOf(frame, marks.facts));
      const size = (most > 1500 ? 7 : most > 300 ? 9 : 12) * this.pixelRatio;
      for (const material of marks.points) material.uniforms.size.value = size;
    }
  }

  setPixelRatio(ratio: number): void {
    this.pixelRatio = ratio;
  }

  setVisible(facts: KindFacts, isVisible: boolean): void {
    this.marks.find((marks) => marks.facts === facts)!.isVisible = isVisible;
    this.update();
  }

  /** Whether the triangles and edges that touch are outlined. */
  setFeatures(hasFeatures: boolean): void {
    this.hasFeatures = hasFeatures;
    this.update();
  }

  private update(): void {
    for (const marks of this.marks)
      for (const object of marks.objects)
        object.visible = marks.isVisible && (this.hasFeatures || object instanceof THREE.Points);
  }
}

function makeMarks(facts: KindFacts): Marks {
  const pointGeometry = new THREE.BufferGeometry();
  const lineGeometry = new THREE.BufferGeometry();
  const points = [true, false].map((isInSight) => pointMaterial(facts, isInSight));
  const lines = [true, false].map(
    (isInSight) =>
      new THREE.LineBasicMaterial({ transparent: true, opacity: isInSight ? 0.9 : 0.12, depthTest: isInSight, depthWrite: false }),
  );
  const objects = [
    ...lines.map((material) => new THREE.LineSegments(lineGeometry, material)),
    ...points.map((material) => new THREE.Points(pointGeometry, material)),
  ];
  objects.forEach((object, index) => {
    object.frustumCulled = false;
    object.renderOrder = 1 + index;
  });
  return { facts, objects, points, lines, pointGeometry, lineGeometry, isVisible: true };
}

function pointMaterial(facts: KindFacts, isInSight: boolean): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX_SHADER,
    fragmentShader: FRAGMENT_SHADER,
    uniforms: {
      color: { value: new THREE.Color() },
      rim: { value: new THREE.Color() },
      opacity: { value: isInSight ? 1 : 0.22 },
      size: { value: 9 },
      shape: { value: facts.shape },
    },
    transparent: true,
    depthTest: isInSight,
    depthWrite: false,
  });
}

function setPositions(geometry: THREE.BufferGeometry, positions: Float32Array): void {
  const attribute = geometry.getAttribute("position") as THREE.BufferAttribute | undefined;
  if (attribute && attribute.array.length >= positions.length) {
    (attribute.array as Float32Array).set(positions);
    attribute.needsUpdate = true;
  } else {
    geometry.dispose();
    const room = new Float32Array(Math.ceil((1.5 * positions.length) / 3) * 3);
    room.set(positions);
    geometry.setAttribute("position", new THREE.BufferAttribute(room, 3).setUsage(THREE.DynamicDrawUsage));
  }
  geometry.setDrawRange(0, positions.length / 3);
}

function pointsOf(frame: FrameMessage, facts: KindFacts): Float32Array {
  const contacts = frame[facts.kind];
  const out = new Float32Array(3 * drawn(frame, facts));
  for (let i = 0, at = 0; i < contacts.length; i += facts.vertices, at += 3) {
    const vertices = contacts.subarray(i, i + facts.vertices);
    out.set(pointOf(frame.positions, facts, vertices), at);
  }
  return out;
}

function pointOf(positions: Float32Array, facts: KindFacts, vertices: Uint32Array): [number, number, number] {
  const [a, b, c, d, e] = vertices;
  switch (facts.kind) {
    case "vertex_triangle":
      return vertexAt(positions, a);
    case "edge_edge":
      return betweenEdges(positions, a, b, c, d);
    case "triangle_triangle":
      return middle(positions, vertices);
    case "edge_triangle":
      return onEdge(positions, a, b, c, d, e);
  }
}

function linesOf(frame: FrameMessage, facts: KindFacts): Float32Array {
  const contacts = frame[facts.kind];
  const out = new Float32Array(3 * facts.lines.length * drawn(frame, facts));
  let at = 0;
  for (let i = 0; i < contacts.length; i += facts.vertices)
    for (const corner of facts.lines) {
      const vertex = 3 * contacts[i + corner];
      out[at++] = frame.positions[vertex];
      out[at++] = frame.positions[vertex + 1];
      out[at++] = frame.positions[vertex + 2];
    }
  return out;
}
