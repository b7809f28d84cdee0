// The picture of a session: what of it is drawn, and how.

import { Box3, Matrix4, Vector3 } from 'three';
import { Ghost, ghostColors, HandBody, ObjectBody } from './bodies';
import { initialsOf, patchColor } from './colors';
import { DepthShade } from './depth';
import { Kinematics, positionsOf } from './kinematics';
import { Marks, type Shown } from './marks';
import { matrixOf } from './mesh';
import type { Session } from './session';
import type { Stage } from './stage';
import type { Tools } from './tools';
import type { PoseSolution } from './wire';

const kSilent_ms = 2000; // a bridge that says nothing for so long is not shown

export interface Look extends Shown {
  depth: boolean;
  map: boolean;
  measured: boolean;
  opacity: number;
}

export class View {
  look: Look = { patches: true, residuals: true, directions: true, depth: true, map: false, measured: true, opacity: 0.55 };
  chosen: string | null = null;
  object: ObjectBody | null = null;
  hand: HandBody | null = null;
  marks: Marks | null = null;
  tools: Tools | null = null;
  /** A pose of the past that is looked at instead. */
  past: PoseSolution | null = null;
  onFirstPicture: () => void = () => undefined;
  private depth: DepthShade | null = null;
  /** What the shells are that are seen; empty: none. */
  ghostText = '';
  measuredText = '';
  onGhosts: () => void = () => undefined;
  private ghost: Ghost | null = null;
  private measured: Ghost | null = null;
  private kinematics: Kinematics | null | undefined; // not known yet; null: of no use for this hand
  private silence = 0;
  private framed = false;
  private initials = new Map<string, string>();
  private order: string[] = [];

  constructor(
    readonly stage: Stage,
    private readonly session: Session,
  ) {}

  colorOf(patch: string): string {
    return patchColor(patch, Math.max(0, this.order.indexOf(patch)));
  }

  initialOf(patch: string): string {
    return this.initials.get(patch) ?? patch.charAt(0).toUpperCase();
  }

  clear(): void {
    this.setGhost(null);
    this.removeGhost(this.measured);
    this.measured = null;
    this.measuredText = '';
    this.kinematics = undefined;
    for (const body of [this.object, this.hand, this.marks]) {
      if (body === null) continue;
      this.stage.scene.remove(body.group);
      body.dispose();
    }
    this.depth?.dispose();
    this.object = this.hand = this.marks = this.depth = null;
    this.past = null;
    this.framed = false;
    this.tools?.work(null);
    this.stage.redraw();
  }

  build(): void {
    const models = this.session.models;
    if (models === null) return;
    this.clear();
    this.order = models.contacts.description.patches.map((patch) => patch.name);
    this.initials = initialsOf(this.order);
    const map = models.contacts.mesh('map');
    this.object = new ObjectBody(
      models.object.mesh('mesh'),
      map.triangles.length > 0 ? map : null,
      models.contacts.floats('map/values'),
    );
    this.hand = new HandBody(models);
    this.hand.setOpacity(this.look.opacity);
    this.hand.group.visible = false;
    this.marks = new Marks((name) => this.colorOf(name), (name) => this.initialOf(name));
    this.depth = new DepthShade(this.hand, this.object, () => this.stage.redraw());
    this.stage.scene.add(this.object.group, this.hand.group, this.marks.group);
    this.object.showMap(this.look.map);
    this.tools?.work({ object: this.object, hand: this.hand, marks: this.marks });
    this.update();
  }

  /** The pose that is shown, and all that hangs on it. */
  update(): void {
    const solution = this.past ?? this.session.solution;
    const { object, hand, marks } = this;
    if (object === null || hand === null || marks === null) return;
    if (solution === null) {
      if (this.session.settings !== null) object.pose(matrixOf(this.session.settings.X_WO));
      this.stage.redraw();
      return;
    }
    const isPlacing = this.tools?.mode === 'object' && this.tools.isBusy;
    if (!isPlacing) object.pose(matrixOf(solution.X_WO));
    hand.group.visible = true;
    hand.pose(solution);
    marks.show(solution, this.session.reports, this.look, this.chosen);
    this.place();
    if (!this.tools?.isBusy) {
      this.tools?.follow();
      this.depth?.update(solution, this.look.depth && this.past === null);
    }
    if (!this.framed) {
      this.framed = true;
      this.chooseSide(solution);
      void this.frame(false).then(() => this.onFirstPicture());
    }
    this.stage.redraw();
  }

  place(): void {
    if (this.object === null || this.hand === null || this.marks === null) return;
    const patches = this.past === null ? (this.session.settings?.patches ?? []) : [];
    this.marks.place(patches, this.object, this.hand, this.look, this.chosen, this.tools?.moved ?? null, this.tools?.turned ?? null);
    this.stage.redraw();
  }

  setLook(change: Partial<Look>): void {
    Object.assign(this.look, change);
    this.hand?.setOpacity(this.look.opacity);
    this.object?.showMap(this.look.map);
    this.showMeasured();
    this.update();
  }

  choose(patch: string | null): void {
    this.chosen = patch;
    this.update();
  }

  /** Another pose beside the one that is shown; `text` says whose it is. */
  setGhost(X_WL: Matrix4[] | null, text = ''): void {
    this.removeGhost(this.ghost);
    this.ghost = null;
    this.ghostText = '';
    if (X_WL !== null && this.hand !== null) {
      this.ghost = this.addGhost(ghostColors.pose, X_WL);
      this.ghostText = text;
    }
    this.onGhosts();
    this.stage.redraw();
  }

  /** The pose of a minimum that the solution ranked; false for a hand whose links only the server can place. */
  ghostOf(rank: number): Matrix4[] | null {
    const solution = this.session.solution;
    const minimum = solution?.minima[rank];
    if (minimum === undefined || !this.understands()) return null;
    return this.kinematics!.poses(minimum.X_WH, positionsOf(this.session.state?.joint_names ?? [], minimum.joint_positions));
  }

  /** The measured hand, while one is heard: its joints, at the palm of the pose. */
  showMeasured(): void {
    const measured = this.session.measured;
    const solution = this.session.solution;
    const isHeard = measured !== null && performance.now() - measured.at_ms < kSilent_ms;
    let X_WL: Matrix4[] | null = null;
    if (this.look.measured && isHeard && solution !== null && this.understands()) {
      const q = positionsOf(this.session.state?.joint_names ?? [], solution.joint_positions);
      measured.hand.names.forEach((name, i) => q.set(name, measured.hand.positions[i]!));
      X_WL = this.kinematics!.poses(solution.X_WH, q);
    }
    const text = X_WL === null ? '' : `measured hand of bridge ${measured!.hand.bridge}`;
    if (X_WL === null) {
      this.removeGhost(this.measured);
      this.measured = null;
    } else if (this.measured === null) {
      this.measured = this.addGhost(ghostColors.measured, X_WL);
    } else {
      this.measured.pose(X_WL);
    }
    if (text !== this.measuredText) {
      this.measuredText = text;
      this.onGhosts();
    }
    clearTimeout(this.silence);
    if (X_WL !== null) this.silence = window.setTimeout(() => this.showMeasured(), kSilent_ms);
    this.stage.redraw();
  }

  /** Whether this page may place the links itself: asked of the server's own pose, once a model. */
  private understands(): boolean {
    const solution = this.session.solution;
    const hand = this.session.models?.hand.description;
    if (this.kinematics === undefined && solution !== null && hand !== undefined && this.session.motion === null) {
      const own = new Kinematics(hand);
      this.kinematics = own.agrees(solution, this.session.state?.joint_names ?? []) ? own : null;
    }
    return Boolean(this.kinematics);
  }

  private addGhost(color: string, X_WL: Matrix4[]): Ghost {
    const ghost = new Ghost(this.hand!, color);
    ghost.pose(X_WL);
    this.stage.scene.add(ghost.group);
    return ghost;
  }

  private removeGhost(ghost: Ghost | null): void {
    if (ghost === null) return;
    this.stage.scene.remove(ghost.group);
    ghost.dispose();
  }

  /** Looks from where most contacts are seen, rather from above than from below. */
  private chooseSide(solution: PoseSolution): void {
    const middle = new Vector3().setFromMatrixPosition(this.object!.X_WO);
    const outward = solution.patches.map((fit) => {
      const sum = new Vector3();
      for (let i = 0; i + 2 < fit.object_W_m.length; i += 3) sum.add(new Vector3().fromArray(fit.object_W_m, i));
      return sum.divideScalar(Math.max(1, fit.object_W_m.length / 3)).sub(middle).normalize();
    });
    let best = new Vector3(0.6, -0.7, 0.45);
    let most = -Infinity;
    for (let i = 0; i < 48; ++i) {
      const around = (2 * Math.PI * (i % 16)) / 16;
      const up = 0.15 + 0.3 * Math.floor(i / 16);
      const from = new Vector3(Math.cos(around), Math.sin(around), up).normalize();
      // A contact on the rim is seen a little, one that faces away is not.
      const seen = outward.reduce((sum, one) => sum + Math.min(0.6, Math.max(-0.1, one.dot(from))), 0);
      if (seen > most + 1e-9) {
        most = seen;
        best = from;
      }
    }
    const eye = middle.clone().addScaledVector(best, 0.6);
    void this.stage.controls.setLookAt(...eye.toArray(), ...middle.toArray(), false);
  }

  async frame(smoothly: boolean): Promise<void> {
    if (this.object === null || this.hand === null) return;
    const box = this.hand.group.visible ? this.hand.box() : new Box3();
    box.union(new Box3().setFromObject(this.object.group));
    // All the way that it goes.
    const here = new Vector3().setFromMatrixPosition(this.object.X_WO);
    const all = box.clone();
    for (const { X_WO } of this.session.motion?.frames ?? []) {
      all.union(box.clone().translate(new Vector3().fromArray(X_WO.p_m).sub(here)));
    }
    box.copy(all);
    await this.stage.frame(box, smoothly);
  }

  /** For tests and the curious: what is in the picture. */
  facts(): Record<string, unknown> {
    const X = (matrix: Matrix4 | undefined) => (matrix === undefined ? null : matrix.elements.slice(12, 15));
    return {
      revision: this.session.solution?.revision ?? -1,
      X_WO: X(this.object?.group.matrix),
      links: this.hand?.links.map((link) => X(link.group.matrix)) ?? [],
      triangles: this.stage.renderer.info.render.triangles,
      geometries: this.stage.renderer.info.memory.geometries,
      textures: this.stage.renderer.info.memory.textures,
      frames: this.stage.frames,
      handles:
        this.marks?.handles
          .filter((handle) => handle.visible)
          .map((handle) => {
            const p = this.stage.project(handle.at_W);
            return { patch: handle.patch, side: handle.side, kind: handle.kind, x: p.x, y: p.y, hidden: Boolean(handle.sprite.userData['hidden']), p_W: handle.p_W.toArray() };
          }) ?? [],
    };
  }
}
