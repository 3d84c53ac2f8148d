// What is seen: camera, lights, surfaces and marks. Draws only when something has changed.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Contacts } from "./contacts";
import { themeColor } from "./kinds";
import type { FrameMessage, SceneMessage } from "./messages";
import { Surfaces } from "./surfaces";

const KEY_TURN = Math.PI / 24;
const KEY_ZOOM = 1.15;

export class Stage {
  readonly surfaces: Surfaces;
  readonly contacts: Contacts;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(40, 1, 0.01, 1000);
  private controls: OrbitControls;
  private readonly sky = new THREE.HemisphereLight();
  private readonly lamp = new THREE.DirectionalLight();
  private isDue = false;
  private isFitted = false;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.camera.up.set(0, 0, 1);
    this.controls = this.makeControls();
    this.lamp.position.set(-0.5, 0.8, 1);
    this.camera.add(this.lamp);
    this.scene.add(this.camera, this.sky);
    this.surfaces = new Surfaces(this.scene);
    this.contacts = new Contacts(this.scene);
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.useTheme();
  }

  /** Reads the colours of the page's theme again. */
  useTheme(): void {
    this.sky.color.set(themeColor("--sky"));
    this.sky.groundColor.set(themeColor("--ground"));
    this.sky.intensity = 2.2;
    this.lamp.intensity = 1.9;
    this.surfaces.useTheme();
    this.contacts.useTheme();
    this.draw();
  }

  showScene(scene: SceneMessage, isSame: boolean): void {
    this.surfaces.showScene(scene);
    this.contacts.clear();
    this.isFitted &&= isSame;
    this.draw();
  }

  showFrame(frame: FrameMessage): void {
    this.surfaces.showFrame(frame);
    this.contacts.showFrame(frame);
    if (!this.isFitted) this.fit();
    this.draw();
  }

  /** Moves the camera so that everything is in sight. */
  fit(): void {
    const sphere = this.surfaces.boundingSphere();
    if (!sphere) return;
    const radius = sphere.radius || 1;
    const halfAngle = THREE.MathUtils.degToRad(this.camera.fov / 2);
    const distance = radius / Math.sin(Math.atan(Math.tan(halfAngle) * Math.min(1, this.camera.aspect)));
    const direction = this.isFitted ? this.camera.position.clone().sub(this.controls.target) : this.startDirection();
    this.isFitted = true;
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(direction.normalize(), 1.12 * distance);
    this.camera.near = distance / 500;
    this.camera.far = distance * 50;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  /** Which axis points up. */
  setUp(axis: "y" | "z"): void {
    this.camera.up.set(0, axis === "y" ? 1 : 0, axis === "z" ? 1 : 0);
    this.controls.dispose();
    this.controls = this.makeControls(); // which take the axis from the camera as they are made
    this.isFitted = false;
    this.fit();
  }

  turn(left: number, up: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const side = new THREE.Vector3().crossVectors(this.camera.up, offset).normalize();
    const angle = offset.angleTo(this.camera.up);
    const tilt = THREE.MathUtils.clamp(angle - up * KEY_TURN, 0.05, Math.PI - 0.05) - angle;
    offset.applyAxisAngle(side, tilt).applyAxisAngle(this.camera.up, left * KEY_TURN);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  zoom(steps: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(KEY_ZOOM ** -steps);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  draw(): void {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.renderer.render(this.scene, this.camera);
    });
  }

  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.addEventListener("change", () => this.draw());
    return controls;
  }

  private startDirection(): THREE.Vector3 {
    return this.camera.up.z ? new THREE.Vector3(0.9, -1.5, 0.75) : new THREE.Vector3(0.9, 0.75, 1.5);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.contacts.setPixelRatio(this.renderer.getPixelRatio());
    this.draw();
  }
}
