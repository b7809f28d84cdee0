// The picture of a session: what of it is drawn, and how.

import { Box3, Matrix4, Vector3 } from 'three';
import { Ghost, ghostColors, HandBody, ObjectBody } from './bodies';
import { initialsOf, patchColor } from './colors';
import { DepthShade } from './depth';
import { DetailMarks, type Details } from './details';
import { Marks, type Root, type Shown } from './marks';
import { matrixOf } from './mesh';
import type { Session } from './session';
import type { Stage } from './stage';
import type { Tools } from './tools';
import type { PatchState, PoseSolution, Side } from './wire';

const kSilent_ms = 2000; // a bridge that says nothing for so long is not shown

export interface Look extends Shown, Details {
  depth: boolean;
  map: boolean;
  measured: boolean;
  opacity: number;
}

export class View {
  look: Look = { patches: true, residuals: true, directions: true, depth: true, map: false, measured: true, opacity: 0.55, sites: false, normals: false, lost: false };
  chosen: string | null = null;
  object: ObjectBody | null = null;
  hand: HandBody | null = null;
  marks: Marks | null = null;
  tools: Tools | null = null;
  /** A pose of the past that is looked at instead. */
  past: PoseSolution | null = null;
  onFirstPicture: () => void = () => undefined;
  private details: DetailMarks | null = null;
  private depth: DepthShade | null = null;
  /** What the shells are that are seen; empty: none. */
  ghostText = '';
  measuredText = '';
  onGhosts: () => void = () => undefined;
  private ghost: Ghost | null = null;
  private measured: Ghost | null = null;
  private isAsking = false; // where the measured hand's links are
  private silence = 0;
  private framed = false;
  private initials = new Map<string, string>();
  private order: string[] = [];

  constructor(
    readonly stage: Stage,
    private readonly session: Session,
  ) {
    stage.onFrame(() => this.details?.size(stage.perPixel));
  }

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
    for (const body of [this.object, this.hand, this.marks, this.details]) {
      if (body === null) continue;
      this.stage.scene.remove(body.group);
      body.dispose();
    }
    this.depth?.dispose();
    this.object = this.hand = this.marks = this.depth = this.details = null;
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
    this.details = new DetailMarks(models.hand.description, (name) => this.colorOf(name));
    this.stage.scene.add(this.object.group, this.hand.group, this.marks.group, this.details.group);
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
      this.stage.release();
      if (this.session.settings !== null) object.pose(matrixOf(this.session.settings.X_WO));
      this.stage.redraw();
      return;
    }
    const isPlacing = this.tools?.mode === 'object' && this.tools.isBusy;
    if (!isPlacing) object.pose(matrixOf(solution.X_WO));
    hand.group.visible = true;
    hand.pose(solution);
    marks.show(solution, this.session.reports, this.look, this.chosen);
    this.details?.show(solution, this.session.reports, this.session.models?.contacts.description.patches ?? [], object, hand, this.look);
    this.place();
    if (!this.tools?.isBusy) {
      this.tools?.follow();
      this.depth?.update(solution, this.look.depth && this.past === null);
    }
    if (!this.framed) {
      this.framed = true;
      this.chooseSide(solution);
      void this.frame(false);
      this.stage.drawNow();
      this.onFirstPicture();
    }
    this.stage.redraw();
  }

  place(): void {
    if (this.object === null || this.hand === null || this.marks === null) return;
    const patches = this.past === null ? (this.session.settings?.patches ?? []) : [];
    const rootOf = (patch: PatchState, side: Side) => (this.session.motion === null ? this.rootOf(patch, side) : this.rootNow(patch, side));
    this.marks.place(patches, rootOf, this.look, this.chosen, this.tools?.moved ?? null, this.tools?.turned ?? null);
    this.stage.redraw();
  }

  private rootOf(patch: PatchState, side: Side): Root | null {
    if (side === 'hand' && !patch.placed) return null;
    const on = side === 'object' ? { ...this.object!.place(patch.root_O), X_W: this.object!.X_WO } : this.hand!.place(patch.root_S);
    if (on === null) return null;
    const d = side === 'object' ? patch.direction_O : patch.direction_S;
    return { ...on, d_W: Math.hypot(...d) > 0.5 ? new Vector3(...d).transformDirection(on.X_W) : null };
  }

  /** Of a motion: the middle of the patch at the time that is shown, its first point as its direction. */
  private rootNow(patch: PatchState, side: Side): Root | null {
    const fit = this.session.solution?.patches.find((one) => one.name === patch.name);
    const at = (side === 'object' ? fit?.object_W_m : fit?.hand_W_m) ?? [];
    if (at.length === 0) return null;
    const middle = new Vector3();
    for (let i = 0; i + 2 < at.length; i += 3) middle.add(new Vector3().fromArray(at, i));
    middle.divideScalar(at.length / 3);
    const on = side === 'object' ? this.object!.nearest(middle) : this.hand!.nearest(middle);
    if (on === null) return null;
    const d_W = new Vector3().fromArray(at).sub(on.p_W);
    return { p_W: on.p_W, n_W: on.n_W, d_W: d_W.length() > 1e-6 ? d_W.normalize() : null };
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

  /** Where the links are in a minimum that the solution ranked, as the server says; null: there is no such one. */
  async ghostOf(rank: number): Promise<Matrix4[] | null> {
    const minimum = this.session.solution?.minima[rank];
    if (minimum === undefined) return null;
    return (await this.session.linkPoses(minimum.X_WH, minimum.joint_positions)).map(matrixOf);
  }

  /** The measured hand, while one is heard: its joints, at the palm of the pose. The newest, as fast as the server says where its links are. */
  showMeasured(): void {
    clearTimeout(this.silence);
    const { measured, solution } = this.session;
    const isHeard = measured !== null && performance.now() - measured.at_ms < kSilent_ms;
    if (!this.look.measured || !isHeard || solution === null || this.hand === null) return this.showMeasuredAt(null);
    this.silence = window.setTimeout(() => this.showMeasured(), kSilent_ms);
    if (this.isAsking) return;
    this.isAsking = true;
    const names = this.session.state?.joint_names ?? [];
    const q = names.map((name, i) => {
      const at = measured.hand.names.indexOf(name);
      return at < 0 ? (solution.joint_positions[i] ?? 0) : measured.hand.positions[at]!;
    });
    this.session
      .linkPoses(solution.X_WH, q)
      .then((X_WL) => this.look.measured && this.hand !== null && this.showMeasuredAt(X_WL.map(matrixOf)))
      .catch(() => undefined) // the next one, perhaps
      .finally(() => {
        this.isAsking = false;
      });
  }

  private showMeasuredAt(X_WL: Matrix4[] | null): void {
    const text = X_WL === null ? '' : `measured hand of bridge ${this.session.measured?.hand.bridge ?? ''}`;
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
    this.stage.redraw();
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
      details: this.details?.facts() ?? null,
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
