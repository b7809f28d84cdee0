// Patches on both surfaces: outlines, roots, directions, and the lines between what should meet.

import {
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  Color,
  DoubleSide,
  Group,
  Mesh as Drawn,
  MeshBasicMaterial,
  Sprite,
  SpriteMaterial,
  Vector3,
} from 'three';
import { order } from './bodies';
import { distanceColor } from './colors';
import { sketch } from './dom';
import { Lines } from './lines';
import type { PatchReport, PatchState, PoseSolution, Side } from './wire';

export const kArm_m = 0.018; // of a direction's arrow

/** A dot that can be dragged: a patch's root, or the end of its direction's arrow. */
export interface Handle {
  patch: string;
  side: Side;
  kind: 'root' | 'direction';
  p_W: Vector3;
  n_W: Vector3;
  at_W: Vector3; // where it is drawn: beside its partner, where they would lie together
  sprite: Sprite;
  visible: boolean;
}

/** Where a patch lies on one side; `d_W`: its direction, if it is known. */
export interface Root {
  p_W: Vector3;
  n_W: Vector3;
  d_W: Vector3 | null;
}

export interface Shown {
  residuals: boolean;
  patches: boolean;
  directions: boolean;
}

function dot(color: string, letter: string, form: 'disc' | 'ring' | 'knob'): CanvasTexture {
  const size = 96;
  const draw = sketch(size, size);
  const circle = (radius: number, fill: string) => {
    draw.beginPath();
    draw.arc(size / 2, size / 2, radius, 0, 2 * Math.PI);
    draw.fillStyle = fill;
    draw.fill();
  };
  circle(46, 'rgba(0,0,0,0.35)');
  circle(43, '#ffffff');
  circle(36, color);
  if (form === 'ring') circle(25, '#ffffff');
  if (form !== 'knob') {
    draw.fillStyle = form === 'ring' ? '#1d2024' : '#ffffff';
    draw.font = `bold ${form === 'ring' ? 34 : 44}px system-ui, sans-serif`;
    draw.textAlign = 'center';
    draw.textBaseline = 'middle';
    draw.fillText(letter, size / 2, size / 2 + 3);
  }
  const texture = new CanvasTexture(draw.canvas);
  texture.colorSpace = 'srgb';
  return texture;
}

export function dotMaterial(map: CanvasTexture): SpriteMaterial {
  return new SpriteMaterial({ map, sizeAttenuation: false, depthTest: false, transparent: true });
}

export function fillMaterial(): MeshBasicMaterial {
  return new MeshBasicMaterial({ transparent: true, depthTest: false, depthWrite: false, side: DoubleSide, forceSinglePass: true });
}

export class Marks {
  readonly group = new Group();
  readonly handles: Handle[] = [];
  private readonly outlines = new Lines({ width: 2.6 });
  private readonly residuals = new Lines({ width: 1.6 });
  private readonly arrows = new Lines({ width: 2.4 });
  private readonly fills = new Map<string, Drawn>();

  constructor(
    private readonly colorOf: (patch: string) => string,
    private readonly initialOf: (patch: string) => string,
  ) {
    this.group.add(this.outlines.group, this.residuals.group, this.arrows.group);
  }

  /** Outlines and residuals of a pose. */
  show(solution: PoseSolution, reports: PatchReport[], shown: Shown, chosen: string | null): void {
    const points: number[] = [];
    const colors: Color[] = [];
    const between: number[] = [];
    const betweenColors: Color[] = [];
    const seen = new Set<string>();
    for (const fit of solution.patches) {
      const report = reports.find((one) => one.name === fit.name);
      // Of a motion's frames that were solved just now the hand's side is not known yet.
      const countOf = (at: number[]) => Math.min(report?.boundary_count ?? at.length / 3, at.length / 3);
      const isOther = chosen !== null && chosen !== fit.name;
      const color = new Color(this.colorOf(fit.name));
      if (shown.patches) {
        for (const [side, at] of [['hand', fit.hand_W_m], ['object', fit.object_W_m]] as const) {
          const tone = isOther ? color.clone().lerp(new Color('#9aa0a6'), 0.45) : color;
          const count = countOf(at);
          if (count < 3) continue;
          for (let i = 0; i < count; ++i) {
            const j = (i + 1) % count;
            points.push(at[3 * i]!, at[3 * i + 1]!, at[3 * i + 2]!, at[3 * j]!, at[3 * j + 1]!, at[3 * j + 2]!);
            colors.push(tone);
          }
          this.fill(`${fit.name} ${side}`, at, count, color, isOther ? 0.1 : 0.26);
          seen.add(`${fit.name} ${side}`);
        }
      }
      if (!shown.residuals) continue;
      for (let i = 0; i < Math.min(fit.hand_W_m.length, fit.object_W_m.length) / 3; ++i) {
        const a = fit.hand_W_m.slice(3 * i, 3 * i + 3);
        const b = fit.object_W_m.slice(3 * i, 3 * i + 3);
        between.push(...a, ...b);
        const mm = 1e3 * Math.hypot(a[0]! - b[0]!, a[1]! - b[1]!, a[2]! - b[2]!);
        betweenColors.push(distanceColor(mm));
      }
    }
    for (const [key, drawn] of this.fills) drawn.visible = seen.has(key);
    this.outlines.set(points, colors);
    this.residuals.set(between, betweenColors);
  }

  /** Dots and arrows where `rootOf` has the roots. `moved` is where a hand holds one right now. */
  place(
    patches: PatchState[],
    rootOf: (patch: PatchState, side: Side) => Root | null,
    shown: Shown,
    chosen: string | null,
    moved: { patch: string; side: Side; p_W: Vector3; n_W: Vector3 } | null,
    turned: { patch: string; side: Side; angle_rad: number } | null,
  ): void {
    const points: number[] = [];
    const colors: Color[] = [];
    const used = new Set<Handle>();
    for (const patch of patches) {
      for (const side of ['object', 'hand'] as const) {
        const on = rootOf(patch, side);
        if (on === null) continue;
        const isMoved = moved !== null && moved.patch === patch.name && moved.side === side;
        const p_W = isMoved ? moved.p_W : on.p_W;
        const n_W = isMoved ? moved.n_W : on.n_W;
        const root = this.handle(patch.name, side, 'root');
        used.add(root);
        root.p_W.copy(p_W);
        root.n_W.copy(n_W);
        // What is laid is the hand's; the object's root is for who looks closer.
        root.visible = shown.patches && (side === 'hand' || patch.name === chosen || !patch.placed);
        root.sprite.material.opacity = patch.enabled ? 1 : 0.35;

        // === Its direction, of the patch that is looked at
        if (!shown.directions || on.d_W === null || patch.name !== chosen) continue;
        const d_W = on.d_W.clone();
        d_W.addScaledVector(n_W, -d_W.dot(n_W)).normalize();
        if (turned !== null && turned.patch === patch.name && turned.side === side) {
          d_W.applyAxisAngle(n_W, turned.angle_rad);
        }
        const tip = p_W.clone().addScaledVector(d_W, kArm_m).addScaledVector(n_W, 0.001);
        const knob = this.handle(patch.name, side, 'direction');
        used.add(knob);
        knob.p_W.copy(tip);
        knob.n_W.copy(n_W);
        knob.visible = true;
        points.push(...p_W.clone().addScaledVector(n_W, 0.001).toArray(), ...tip.toArray());
        colors.push(new Color(this.colorOf(patch.name)));
      }
    }
    this.arrows.set(points, colors);
    for (const handle of this.handles) {
      if (!used.has(handle)) handle.visible = false;
      handle.sprite.visible = handle.visible;
      handle.at_W.copy(handle.p_W);
      handle.sprite.position.copy(handle.p_W);
    }
  }

  dispose(): void {
    for (const lines of [this.outlines, this.residuals, this.arrows]) lines.dispose();
    for (const drawn of this.fills.values()) {
      drawn.geometry.dispose();
      (drawn.material as MeshBasicMaterial).dispose();
    }
    for (const handle of this.handles) {
      handle.sprite.material.map?.dispose();
      handle.sprite.material.dispose();
    }
  }

  private handle(patch: string, side: Side, kind: Handle['kind']): Handle {
    const found = this.handles.find((one) => one.patch === patch && one.side === side && one.kind === kind);
    if (found !== undefined) return found;
    const form = kind === 'direction' ? 'knob' : side === 'hand' ? 'disc' : 'ring';
    const material = dotMaterial(dot(this.colorOf(patch), this.initialOf(patch), form));
    const sprite = new Sprite(material);
    sprite.renderOrder = order.dots + (kind === 'direction' ? 2 : side === 'hand' ? 1 : 0);
    this.group.add(sprite);
    const made: Handle = { patch, side, kind, p_W: new Vector3(), n_W: new Vector3(), at_W: new Vector3(), sprite, visible: true };
    this.handles.push(made);
    return made;
  }

  /** A tint over the patch, so that it is seen as an area. */
  private fill(key: string, at: number[], count: number, color: Color, opacity: number): void {
    let drawn = this.fills.get(key);
    if (drawn === undefined || drawn.userData['count'] !== count) {
      if (drawn !== undefined) {
        this.group.remove(drawn);
        drawn.geometry.dispose();
      }
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(new Float32Array(3 * (count + 1)), 3));
      const index: number[] = [];
      for (let i = 0; i < count; ++i) index.push(count, i, (i + 1) % count);
      geometry.setIndex(index);
      drawn = new Drawn(geometry, fillMaterial());
      drawn.frustumCulled = false;
      drawn.renderOrder = order.marks - 2;
      drawn.userData['count'] = count;
      this.fills.set(key, drawn);
      this.group.add(drawn);
    }
    const material = drawn.material as MeshBasicMaterial;
    material.color.copy(color);
    material.opacity = opacity;
    const position = drawn.geometry.attributes['position'] as BufferAttribute;
    const middle = [0, 0, 0];
    for (let i = 0; i < count; ++i) {
      for (let k = 0; k < 3; ++k) {
        position.array[3 * i + k] = at[3 * i + k]!;
        middle[k]! += at[3 * i + k]! / count;
      }
    }
    position.array.set(middle, 3 * count);
    position.needsUpdate = true;
  }
}
