// Renderer, camera and light; drawn when something changed.

import CameraControls from 'camera-controls';
import {
  Box3,
  Color,
  DirectionalLight,
  HemisphereLight,
  MathUtils,
  Matrix4,
  Object3D,
  PerspectiveCamera,
  Quaternion,
  Raycaster,
  Scene,
  Sphere,
  Spherical,
  Vector2,
  Vector3,
  Vector4,
  WebGLRenderer,
} from 'three';

CameraControls.install({
  THREE: { Vector2, Vector3, Vector4, Quaternion, Matrix4, Spherical, Box3, Sphere, Raycaster, MathUtils } as never,
});

const kBackground = { light: 0xf4f5f3, dark: 0x16181b };

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(35, 1, 0.005, 20);
  readonly controls: CameraControls;
  readonly renderer: WebGLRenderer;
  readonly size = new Vector2(1, 1);
  readonly raycaster = new Raycaster();
  frames = 0;

  private dirty = true;
  private last_ms = 0;
  private readonly before: (() => void)[] = [];

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    Object3D.DEFAULT_UP.set(0, 0, 1);
    this.camera.up.set(0, 0, 1);
    const sky = new HemisphereLight(0xffffff, 0x6b6f76, 1.5);
    sky.position.set(0, 0, 1);
    const key = new DirectionalLight(0xffffff, 1.9);
    key.position.set(0.6, -0.8, 1.2);
    this.camera.add(key); // it comes over the viewer's shoulder
    this.scene.add(sky, this.camera);

    this.controls = new CameraControls(this.camera, canvas);
    this.controls.dollyToCursor = true;
    this.controls.smoothTime = 0.12;
    this.controls.draggingSmoothTime = 0.06;
    this.controls.minDistance = 0.03;
    this.controls.maxDistance = 5;
    this.controls.addEventListener('update', () => this.redraw());
    this.controls.setLookAt(0.35, -0.45, 0.3, 0, 0, 0);
    new ResizeObserver(() => this.fit()).observe(canvas);
    this.fit();
    requestAnimationFrame((now) => this.tick(now));
  }

  redraw(): void {
    this.dirty = true;
  }

  /** Called before each picture. */
  onFrame(step: () => void): void {
    this.before.push(step);
  }

  setTheme(theme: 'light' | 'dark'): void {
    this.scene.background = new Color(kBackground[theme]);
    this.redraw();
  }

  /** All of that in view. */
  async frame(box: Box3, smoothly: boolean): Promise<void> {
    if (box.isEmpty()) return;
    const sphere = box.getBoundingSphere(new Sphere());
    sphere.radius *= 0.92;
    await this.controls.fitToSphere(sphere, smoothly);
  }

  /** A ray through a place of the canvas, in CSS pixels. */
  rayAt(x: number, y: number): Raycaster {
    const at = new Vector2((2 * x) / this.size.x - 1, 1 - (2 * y) / this.size.y);
    this.camera.updateMatrixWorld();
    this.raycaster.setFromCamera(at, this.camera);
    this.raycaster.firstHitOnly = true;
    return this.raycaster;
  }

  /** Where a point of the world is on the canvas, in CSS pixels; z > 1: behind the camera. */
  project(p_W: Vector3): Vector3 {
    const p = p_W.clone().project(this.camera);
    return new Vector3(((p.x + 1) * this.size.x) / 2, ((1 - p.y) * this.size.y) / 2, p.z);
  }

  /** The point of the world that is seen there, at a depth that `project` gave. */
  unproject(x: number, y: number, z: number): Vector3 {
    return new Vector3((2 * x) / this.size.x - 1, 1 - (2 * y) / this.size.y, z).unproject(this.camera);
  }

  /** Of sprites whose size does not depend on the distance. */
  get perPixel(): number {
    return (2 * Math.tan((this.camera.fov * Math.PI) / 360)) / this.size.y;
  }

  png(): Promise<Blob | null> {
    this.draw();
    return new Promise((resolve) => this.canvas.toBlob(resolve, 'image/png'));
  }

  private fit(): void {
    const seen = this.canvas.getBoundingClientRect();
    this.size.set(Math.max(1, seen.width), Math.max(1, seen.height));
    this.renderer.setSize(this.size.x, this.size.y, false);
    this.camera.aspect = this.size.x / this.size.y;
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  private tick(now: number): void {
    const step_s = Math.min(0.1, (now - this.last_ms) / 1000);
    this.last_ms = now;
    if (this.controls.update(step_s)) this.dirty = true;
    if (this.dirty) this.draw();
    requestAnimationFrame((next) => this.tick(next));
  }

  private draw(): void {
    this.dirty = false;
    for (const step of this.before) step();
    this.renderer.render(this.scene, this.camera);
    ++this.frames;
  }
}
