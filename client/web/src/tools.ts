// What a pointer does on the picture: drag dots, fingers, the palm, the object; else it turns the view.

import { Matrix4, Object3D, Plane, Quaternion, Vector3 } from 'three';
import { TransformControls } from 'three/examples/jsm/controls/TransformControls.js';
import type { HandBody, LinkBody, ObjectBody, Pick } from './bodies';
import type { Handle, Marks } from './marks';
import type { Drag } from './drag';
import type { Session } from './session';
import type { Stage } from './stage';
import { edits, type Side } from './wire';

export type Mode = 'patches' | 'fingers' | 'object' | 'palm';

export interface Moved {
  patch: string;
  side: Side;
  p_W: Vector3;
  n_W: Vector3;
}

export interface Turned {
  patch: string;
  side: Side;
  angle_rad: number;
}

/** What the tools work on. */
export interface Scenery {
  object: ObjectBody;
  hand: HandBody;
  marks: Marks;
}

export interface Told {
  onChoose(patch: string | null): void;
  onHover(patch: string | null): void;
  onMoved(): void;
  /** The hand is dragged on, as it is posed now; or no longer. */
  onGrip(isHeld: boolean): void;
  onHint(text: string): void;
}

const kApart_px = 22;
const kReach_px = { mouse: 14, touch: 26 };
const kPalmHold = 30; // it stays where it was put, turned so, too, until it is let go: contacts would have it back at once
const kRaw_ms = 12; // between two of a pointer's moves that are looked at
const kKeyStep_m = 0.002;
const kKeyTurn = Math.PI / 60;
const kFingerHold = 1; // of a part of the hand, until it is let go: contacts would have it back at once, too

interface Held {
  pointer: number;
  drag: Drag;
  move(x: number, y: number): void;
  end(): void;
}

export class Tools {
  mode: Mode = 'patches';
  moved: Moved | null = null;
  turned: Turned | null = null;
  private held: Held | null = null;
  private scenery: Scenery | null = null;
  private readonly proxy = new Object3D();
  private readonly gizmo: TransformControls;
  private placing: Drag | null = null;
  private raw_ms = 0;
  private hovered: Handle | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly session: Session,
    private readonly told: Told,
  ) {
    const canvas = stage.canvas;
    // Before the camera's own listeners, so that a dot that is dragged does not turn the view.
    const options = { capture: true };
    const area = canvas.parentElement!;
    area.addEventListener('pointerdown', (event) => this.down(event), options);
    area.addEventListener('pointermove', (event) => this.move(event), options);
    for (const end of ['pointerup', 'pointercancel'] as const) {
      area.addEventListener(end, (event) => this.up(event), options);
    }
    stage.onFrame(() => this.sizeDots());

    this.gizmo = new TransformControls(stage.camera, canvas);
    this.gizmo.setSpace('world');
    this.gizmo.setSize(0.8);
    this.gizmo.attach(this.proxy);
    this.gizmo.getHelper().visible = false;
    this.gizmo.enabled = false;
    stage.scene.add(this.proxy, this.gizmo.getHelper());
    this.gizmo.addEventListener('change', () => stage.redraw());
    this.gizmo.addEventListener('dragging-changed', (event) => {
      const isDragging = event.value as boolean;
      stage.controls.enabled = !isDragging;
      if (isDragging) {
        this.placing = this.session.editing.drag();
        if (this.mode === 'palm') this.told.onGrip(true);
      } else {
        this.placing?.end();
        this.placing = null;
        this.told.onGrip(false);
      }
    });
    this.gizmo.addEventListener('objectChange', () => {
      if (this.placing !== null) this.place(this.placing);
    });
  }

  work(scenery: Scenery | null): void {
    this.scenery = scenery;
    this.moved = this.turned = null;
    this.setMode(this.mode);
  }

  get isBusy(): boolean {
    return this.held !== null || this.placing !== null;
  }

  setMode(mode: Mode): void {
    this.mode = mode;
    const isShown = this.hasGizmo && this.scenery !== null && this.session.mayEdit;
    this.gizmo.getHelper().visible = isShown;
    this.gizmo.enabled = isShown;
    this.follow();
    this.told.onHint(this.hint());
    this.stage.redraw();
  }

  turnGizmo(way: 'translate' | 'rotate'): void {
    this.gizmo.setMode(way);
    this.stage.redraw();
  }

  private get hasGizmo(): boolean {
    return this.mode === 'object' || this.mode === 'palm';
  }

  /** The gizmo goes where the object or the palm went. */
  follow(): void {
    if (this.scenery === null || this.placing !== null) return;
    const X_W = this.mode === 'palm' ? this.scenery.hand.links[0]?.group.matrix : this.scenery.object.X_WO;
    X_W?.decompose(this.proxy.position, this.proxy.quaternion, this.proxy.scale);
  }

  /** The object or the palm, moved or turned by so much as the viewer sees it: for keys. */
  step(key: string, turns: boolean): void {
    if (!this.hasGizmo || this.scenery === null || !this.session.mayEdit || this.placing !== null) return;
    const axis = (column: number) => new Vector3().setFromMatrixColumn(this.stage.camera.matrixWorld, column);
    const [column, sign] = ({ arrowright: [0, 1], arrowleft: [0, -1], arrowup: [1, 1], arrowdown: [1, -1], pageup: [2, -1], pagedown: [2, 1] } as const)[key] ?? [0, 0];
    if (turns) {
      // Right turns about what points up, up about what points right.
      const about = axis(column === 2 ? 2 : 1 - column).multiplyScalar(column === 1 ? -1 : 1);
      this.proxy.quaternion.premultiply(new Quaternion().setFromAxisAngle(about, sign * kKeyTurn));
    } else {
      this.proxy.position.addScaledVector(axis(column), sign * kKeyStep_m);
    }
    const drag = this.session.editing.drag();
    this.place(drag);
    drag.end();
    this.stage.redraw();
  }

  hint(): string {
    if (!this.session.mayEdit) return 'Drag to turn the view, scroll to come closer.';
    switch (this.mode) {
      case 'patches':
        return 'Drag a coloured dot over the hand: the contact is laid there, and the hand follows.';
      case 'fingers':
        return 'Drag any part of the hand: it goes there, the contacts give way. It stays there until you let it go.';
      case 'object':
        return 'Drag the arrows to move the object; “Turn” turns it. Arrow keys move it, with Shift they turn it.';
      case 'palm':
        return 'Drag the arrows to move the palm; “Turn” turns it. It stays there until you let it go.';
    }
  }

  /** A root moved by so much, along the surface: for keys. */
  nudge(patch: string, side: Side, step_W: Vector3): void {
    const at = this.scenery?.marks.handles.find((one) => one.patch === patch && one.side === side && one.kind === 'root');
    if (at === undefined || this.scenery === null) return;
    const body = side === 'object' ? this.scenery.object : this.scenery.hand;
    const to = body.nearest(at.p_W.clone().add(step_W));
    if (to === null) return;
    at.p_W.copy(to.p_W);
    void this.session.editing.edit(edits.root(patch, side, to.root));
  }

  // === Pointers

  private at(event: PointerEvent): [number, number] {
    const around = this.stage.canvas.getBoundingClientRect();
    return [event.clientX - around.left, event.clientY - around.top];
  }

  private dotAt(x: number, y: number, touch: boolean): Handle | null {
    if (this.scenery === null || this.mode !== 'patches') return null;
    let best: Handle | null = null;
    let nearest = touch ? kReach_px.touch : kReach_px.mouse;
    for (const handle of this.scenery.marks.handles) {
      if (!handle.visible) continue;
      const p = this.stage.project(handle.at_W);
      if (p.z > 1) continue;
      const distance = Math.hypot(p.x - x, p.y - y);
      if (distance < nearest) {
        nearest = distance;
        best = handle;
      }
    }
    return best;
  }

  private down(event: PointerEvent): void {
    if (event.target !== this.stage.canvas || this.held !== null || event.button !== 0) return;
    if (this.hasGizmo && this.gizmo.axis !== null) return;
    const [x, y] = this.at(event);
    const handle = this.dotAt(x, y, event.pointerType === 'touch');
    if (handle !== null) {
      this.told.onChoose(handle.patch);
      if (this.session.mayEdit) this.held = handle.kind === 'root' ? this.holdRoot(event, handle) : this.holdDirection(event, handle);
    } else if (this.mode === 'fingers' && this.session.mayEdit) {
      this.held = this.holdFinger(event, x, y);
    }
    if (this.held === null && handle === null) return;
    event.stopPropagation();
    event.preventDefault();
    this.stage.canvas.focus({ focusVisible: false } as FocusOptions);
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.stage.controls.enabled = false;
    document.body.classList.add('dragging');
    if (this.held !== null) this.stage.canvas.addEventListener('pointerrawupdate', this.moveRaw);
  }

  /** Moves as they happen: a browser hands out the usual ones with its pictures, which may be slow. */
  private readonly moveRaw = (event: Event): void => {
    const now = performance.now();
    if (this.held === null || (event as PointerEvent).pointerId !== this.held.pointer || now - this.raw_ms < kRaw_ms) return;
    this.raw_ms = now;
    this.held.move(...this.at(event as PointerEvent));
  };

  private move(event: PointerEvent): void {
    const [x, y] = this.at(event);
    if (this.held !== null) {
      if (event.pointerId !== this.held.pointer) return;
      event.stopPropagation();
      this.held.move(x, y);
      return;
    }
    if (event.buttons !== 0 || event.pointerType === 'touch') return;
    const handle = this.dotAt(x, y, false);
    if (handle !== this.hovered) {
      this.hovered = handle;
      this.told.onHover(handle?.patch ?? null);
      this.stage.redraw();
    }
    const canGrip = this.mode === 'fingers' && this.session.mayEdit && this.scenery?.hand.pickLink(this.stage.rayAt(x, y));
    this.stage.canvas.style.cursor = handle !== null || canGrip ? 'grab' : '';
  }

  private up(event: PointerEvent): void {
    if (this.stage.controls.enabled === false && this.placing === null) this.stage.controls.enabled = true;
    document.body.classList.remove('dragging');
    this.stage.canvas.removeEventListener('pointerrawupdate', this.moveRaw);
    if (this.held === null || event.pointerId !== this.held.pointer) return;
    event.stopPropagation();
    this.held.drag.end();
    this.held.end();
    this.held = null;
  }

  private holdRoot(event: PointerEvent, handle: Handle): Held {
    const { patch, side } = handle;
    const drag = this.session.editing.drag();
    const { object, hand } = this.scenery!;
    // The hand moves while it is dragged on, so that the pointer goes over it as it was.
    const posed = hand.poses();
    if (side === 'hand') this.told.onGrip(true);
    const [x0, y0] = this.at(event);
    const grip = this.stage.project(handle.p_W); // not where it is drawn
    const [dx, dy] = [grip.x - x0, grip.y - y0];
    return {
      pointer: event.pointerId,
      drag,
      move: (x, y) => {
        const ray = this.stage.rayAt(x + dx, y + dy);
        const to: Pick | null = side === 'object' ? object.pick(ray) : hand.pick(ray, posed);
        if (to === null) return; // past its rim: it stays there
        this.moved = { patch, side, p_W: to.p_W, n_W: to.n_W };
        drag.move(edits.root(patch, side, to.root));
        this.told.onMoved();
      },
      end: () => this.letGo(),
    };
  }

  private holdDirection(event: PointerEvent, handle: Handle): Held {
    const { patch, side } = handle;
    const drag = this.session.editing.drag();
    const root = this.scenery!.marks.handles.find((one) => one.patch === patch && one.side === side && one.kind === 'root')!;
    const plane = new Plane().setFromNormalAndCoplanarPoint(root.n_W, root.p_W);
    const center = root.p_W.clone();
    const normal = root.n_W.clone();
    const begin = handle.p_W.clone().sub(center).projectOnPlane(normal).normalize();
    const other = normal.clone().cross(begin);
    let last = 0;
    let sent = 0;
    return {
      pointer: event.pointerId,
      drag,
      move: (x, y) => {
        const on = this.stage.rayAt(x, y).ray.intersectPlane(plane, new Vector3());
        if (on === null) return;
        const arm = on.sub(center);
        let angle = Math.atan2(arm.dot(other), arm.dot(begin));
        angle += 2 * Math.PI * Math.round((last - angle) / (2 * Math.PI)); // round and round
        last = angle;
        this.turned = { patch, side, angle_rad: angle };
        drag.move(() => {
          const step = last - sent;
          sent = last;
          return edits.turn(patch, side, step);
        });
        this.told.onMoved();
      },
      end: () => this.letGo(),
    };
  }

  private holdFinger(event: PointerEvent, x: number, y: number): Held | null {
    const grip = this.scenery?.hand.pickLink(this.stage.rayAt(x, y));
    if (!grip) return null;
    const drag = this.session.editing.drag();
    const link: LinkBody = grip.link;
    const p_L = grip.p_L.toArray();
    const plane = new Plane().setFromNormalAndCoplanarPoint(
      this.stage.camera.getWorldDirection(new Vector3()),
      grip.p_W,
    );
    return {
      pointer: event.pointerId,
      drag,
      move: (toX, toY) => {
        const to = this.stage.rayAt(toX, toY).ray.intersectPlane(plane, new Vector3());
        if (to === null) return;
        drag.move(edits.drag(link.name, p_L, to.toArray(), kFingerHold));
        this.told.onMoved();
      },
      end: () => this.letGo(),
    };
  }

  /** The dot stays where it was put until the session says where that is. */
  private letGo(): void {
    this.told.onGrip(false);
    const moved = this.moved;
    const turned = this.turned;
    setTimeout(() => {
      if (this.moved === moved) this.moved = null;
      if (this.turned === turned) this.turned = null;
      this.told.onMoved();
    }, 600);
  }

  /** The object or the palm goes where the gizmo is. */
  private place(drag: Drag): void {
    if (this.scenery === null) return;
    const { position, quaternion } = this.proxy;
    const q = [quaternion.w, quaternion.x, quaternion.y, quaternion.z] as [number, number, number, number];
    if (this.mode === 'palm') {
      const link = this.scenery.hand.links[0];
      if (link !== undefined) drag.move(edits.drag(link.name, [0, 0, 0], position.toArray(), kPalmHold, q));
      return;
    }
    this.scenery.object.pose(new Matrix4().compose(position, quaternion, new Vector3(1, 1, 1)));
    drag.move(edits.place({ p_m: position.toArray(), q_wxyz: q }));
    this.told.onMoved();
  }

  /** The object's dot is drawn beside the hand's where both would lie together, so that either can be taken. */
  private spreadDots(): void {
    const roots = this.scenery!.marks.handles.filter((one) => one.visible && one.kind === 'root');
    const middle = this.stage.project(new Vector3().setFromMatrixPosition(this.scenery!.object.X_WO));
    for (const handle of roots) {
      handle.at_W.copy(handle.p_W);
      if (handle.side === 'object') {
        const partner = roots.find((one) => one.patch === handle.patch && one.side === 'hand');
        if (partner !== undefined) {
          const mine = this.stage.project(handle.p_W);
          const its = this.stage.project(partner.p_W);
          let [dx, dy] = [mine.x - its.x, mine.y - its.y];
          const apart = Math.hypot(dx, dy);
          if (apart < kApart_px) {
            if (apart < 3) [dx, dy] = [its.x - middle.x, its.y - middle.y];
            const length = Math.hypot(dx, dy) || 1;
            handle.at_W.copy(this.stage.unproject(its.x + (kApart_px * dx) / length, its.y + (kApart_px * dy) / length, mine.z));
          }
        }
      }
      handle.sprite.position.copy(handle.at_W);
    }
  }

  /** Dots as large as fingers and eyes need, whatever the distance; those behind a surface are faint. */
  private sizeDots(): void {
    if (this.scenery === null) return;
    this.spreadDots();
    const { perPixel } = this.stage;
    for (const handle of this.scenery.marks.handles) {
      if (!handle.visible) continue;
      const isHot = handle === this.hovered || (this.moved?.patch === handle.patch && this.moved.side === handle.side);
      const pixels = (handle.kind === 'direction' ? 16 : handle.side === 'hand' ? 26 : 20) * (isHot ? 1.3 : 1) * (this.mode === 'patches' ? 1 : 0.6);
      handle.sprite.scale.setScalar(perPixel * pixels);
      const p = this.stage.project(handle.p_W);
      const toward = this.stage.camera.position.clone().sub(handle.p_W).normalize();
      const isHidden = handle.n_W.dot(toward) < -0.15 && p.z < 1;
      handle.sprite.userData['hidden'] = isHidden;
      handle.sprite.material.color.setScalar(isHidden ? 0.72 : 1);
    }
  }
}
