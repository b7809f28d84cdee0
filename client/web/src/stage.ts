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

const kAttributes: WebGLContextAttributes = { alpha: true, depth: true, stencil: false, premultipliedAlpha: true, antialias: false, preserveDrawingBuffer: true };
const kStill_ms = 250; // without a change

const kSoftware = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** A canvas, and what draws on it. Smooth edges are for graphics cards; software takes twice as long for them. */
function surface(make: () => HTMLCanvasElement): { canvas: HTMLCanvasElement; context: WebGL2RenderingContext | undefined; isSoftware: boolean } {
  const canvas = make();
  const context = (canvas.getContext('webgl2', kAttributes) as WebGL2RenderingContext | null) ?? undefined;
  const names = context?.getExtension('WEBGL_debug_renderer_info');
  const name = context === undefined || !names ? '' : String(context.getParameter(names.UNMASKED_RENDERER_WEBGL));
  const isSoftware = kSoftware.test(name);
  if (isSoftware || context === undefined) return { canvas, context, isSoftware };
  context.getExtension('WEBGL_lose_context')?.loseContext();
  const smooth = make();
  return { canvas: smooth, context: (smooth.getContext('webgl2', { ...kAttributes, antialias: true }) as WebGL2RenderingContext | null) ?? undefined, isSoftware };
}

const kBackground = { light: 0xf4f5f3, dark: 0x16181b };

export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(35, 1, 0.005, 20);
  readonly controls: CameraControls;
  readonly renderer: WebGLRenderer;
  readonly size = new Vector2(1, 1);
  readonly raycaster = new Raycaster();
  frames = 0;

  private readonly isSoftware: boolean;
  /** Where software draws, edges are smooth once nothing moves: drawn twice as fine. */
  private isFine = false;
  private drawn_ms = 0;
  /** Passed by the graphics card once the last picture is drawn; null: it is. */
  private fence: WebGLSync | null = null;
  private isPressed = false;
  private isHeld = true;
  private dirty = true;
  private last_ms = 0;
  private readonly before: (() => void)[] = [];

  readonly canvas: HTMLCanvasElement;

  constructor(make: () => HTMLCanvasElement) {
    const { canvas, context, isSoftware } = surface(make);
    this.canvas = canvas;
    this.isSoftware = isSoftware;
    this.renderer = new WebGLRenderer({ canvas, context });
    this.renderer.debug.checkShaderErrors = false; // whoever asks waits for the graphics card
    this.renderer.setPixelRatio(this.ratio);
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
    canvas.addEventListener('pointerdown', () => (this.isPressed = true), { capture: true });
    for (const end of ['pointerup', 'pointercancel']) addEventListener(end, () => (this.isPressed = false), { capture: true });
    new ResizeObserver(() => this.fit()).observe(canvas);
    this.fit();
    requestAnimationFrame((now) => this.tick(now));
  }

  /** Has the graphics card make the programs of what will be drawn; nobody waits for them. */
  warm(samples: Object3D): void {
    this.renderer.compile(samples, this.camera, this.scene);
  }

  /** There is something to draw, or nothing will come: an empty picture would only keep the graphics card from its work. */
  release(): void {
    this.isHeld = false;
  }

  /** At once: a picture that somebody waits for. */
  drawNow(): void {
    this.isHeld = false;
    this.controls.update(0);
    this.draw();
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
    if (this.isSoftware) this.drawFine();
    else this.draw();
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
    requestAnimationFrame((next) => this.tick(next));
    if (this.controls.update(step_s)) this.dirty = true;
    if (this.isHeld) this.dirty = true;
    else if (this.isDrawing()) return; // the browser would make mouse and edits wait for the next picture as well
    else if (this.dirty) this.draw();
    else if (this.isSoftware && !this.isFine && !this.isPressed && now - this.drawn_ms > kStill_ms) this.drawFine();
  }

  /** The graphics card is still at the last picture. */
  private isDrawing(): boolean {
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    if (this.fence !== null && (gl.isContextLost() || gl.getSyncParameter(this.fence, gl.SYNC_STATUS) === gl.SIGNALED)) {
      gl.deleteSync(this.fence);
      this.fence = null;
    }
    return this.fence !== null;
  }

  private render(): void {
    for (const step of this.before) step();
    this.renderer.render(this.scene, this.camera);
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    gl.deleteSync(this.fence);
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }

  private get ratio(): number {
    return Math.min(devicePixelRatio, 2);
  }

  private drawFine(): void {
    this.isFine = true;
    this.renderer.setPixelRatio(2);
    this.render();
  }

  private draw(): void {
    this.dirty = false;
    if (this.isFine) this.renderer.setPixelRatio(this.ratio);
    this.isFine = false;
    this.drawn_ms = performance.now();
    this.render();
    ++this.frames;
  }
}
