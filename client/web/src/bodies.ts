// The hand and the object: drawn, posed, picked.

import {
  BackSide,
  Box3,
  BufferGeometry,
  Color,
  DoubleSide,
  Group,
  Matrix4,
  Mesh as Drawn,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Ray,
  Raycaster,
  Vector3,
} from 'three';
import { viridis } from './scale';
import { acceleratedRaycast, geometryOf, matrixOf, normalOf, paint, pickingGeometry, positionOf, surfacePoint, treeOf } from './mesh';
import type { Models } from './session';
import type { Mesh, PoseSolution, SurfacePoint } from './wire';

Drawn.prototype.raycast = acceleratedRaycast;

const kHand = new Color('#b9bec6');
const kObject = new Color('#d9b77e');

// What is drawn in which order: what the hand shows through is drawn before it.
export const order = { handDepth: 10, hand: 11, marks: 20, dots: 30 };

export interface Pick {
  root: SurfacePoint;
  p_W: Vector3;
  n_W: Vector3;
}

// Without gloss: the programs of physical materials take a graphics card of software half a second to make.
export function objectMaterial(): MeshLambertMaterial {
  return new MeshLambertMaterial({ color: kObject, side: DoubleSide });
}

export function handMaterial(): MeshLambertMaterial {
  return new MeshLambertMaterial({ color: kHand, transparent: true, opacity: 0.6, side: DoubleSide, forceSinglePass: true });
}

/** The hand's depth is drawn first, among what is transparent: one layer shows, not all of them. */
export function handDepthMaterial(): MeshBasicMaterial {
  return new MeshBasicMaterial({ colorWrite: false, transparent: true, side: DoubleSide, forceSinglePass: true });
}

/** A mesh that lies in a frame which moves. */
function hitOn(geometry: BufferGeometry, X_W: Matrix4, ray_W: Ray): { face: number; p: Vector3; distance: number } | null {
  const ray = ray_W.clone().applyMatrix4(X_W.clone().invert());
  const hit = treeOf(geometry).raycastFirst(ray, DoubleSide);
  if (!hit || hit.faceIndex === undefined || hit.faceIndex === null) return null;
  return { face: hit.faceIndex, p: hit.point, distance: hit.distance };
}

export class ObjectBody {
  readonly group = new Group();
  readonly geometry: BufferGeometry;
  readonly X_WO = new Matrix4();
  readonly material = objectMaterial();
  private readonly map: Drawn | null = null;
  private readonly surface: Drawn;

  constructor(readonly mesh: Mesh, map: Mesh | null, values: Float32Array) {
    this.geometry = geometryOf(mesh);
    this.group.matrixAutoUpdate = false;
    this.surface = new Drawn(this.geometry, this.material);
    this.group.add(this.surface);
    if (map !== null && values.length > 0) {
      const geometry = geometryOf(map);
      const colors = new Float32Array(map.vertices.length);
      const highest = values.reduce((most, value) => Math.max(most, value), 1e-12);
      values.forEach((value, vertex) => viridis(value / highest).toArray(colors, 3 * vertex));
      paint(geometry, colors);
      this.map = new Drawn(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide }));
      this.map.visible = false;
      this.group.add(this.map);
    }
  }

  get hasMap(): boolean {
    return this.map !== null;
  }

  showMap(shown: boolean): void {
    if (this.map === null) return;
    this.map.visible = shown;
    this.surface.visible = !shown;
  }

  pose(X_WO: Matrix4): void {
    this.X_WO.copy(X_WO);
    this.group.matrix.copy(X_WO);
    this.group.updateMatrixWorld(true);
  }

  pick(caster: Raycaster): Pick | null {
    const hit = hitOn(this.geometry, this.X_WO, caster.ray);
    if (hit === null) return null;
    return {
      root: surfacePoint(this.mesh, hit.face, hit.p),
      p_W: hit.p.clone().applyMatrix4(this.X_WO),
      n_W: normalOf(this.mesh, hit.face).transformDirection(this.X_WO),
    };
  }

  /** The place of the surface that is nearest to a point. */
  nearest(p_W: Vector3): Pick | null {
    const p = p_W.clone().applyMatrix4(this.X_WO.clone().invert());
    const hit = treeOf(this.geometry).closestPointToPoint(p);
    if (hit === null) return null;
    return {
      root: surfacePoint(this.mesh, hit.faceIndex, hit.point),
      p_W: hit.point.clone().applyMatrix4(this.X_WO),
      n_W: normalOf(this.mesh, hit.faceIndex).transformDirection(this.X_WO),
    };
  }

  place(root: SurfacePoint): { p_W: Vector3; n_W: Vector3 } {
    return {
      p_W: positionOf(this.mesh, root).applyMatrix4(this.X_WO),
      n_W: normalOf(this.mesh, root.face).transformDirection(this.X_WO),
    };
  }

  dispose(): void {
    this.geometry.dispose();
    this.material.dispose();
    if (this.map !== null) this.map.geometry.dispose();
  }
}

/** One link: its own surface, and the part of the skin that moves with it. */
export interface LinkBody {
  name: string;
  mesh: Mesh;
  geometry: BufferGeometry;
  group: Group;
  drawn: Drawn;
  X_SL: Matrix4;
  skinFaces: Uint32Array;
  skin: BufferGeometry | null;
}

export class HandBody {
  readonly group = new Group();
  readonly links: LinkBody[] = [];
  readonly material = handMaterial();
  private readonly skin: Mesh;
  private readonly faceLinks: Int32Array;
  private readonly depthMaterial = handDepthMaterial();

  constructor(models: Models) {
    const hand = models.hand;
    this.skin = hand.mesh('skin');
    this.faceLinks = hand.ints('skin/links');
    const facesOf: number[][] = hand.description.links.map(() => []);
    this.faceLinks.forEach((link, face) => facesOf[link]?.push(face));
    hand.description.links.forEach((info, index) => {
      const mesh = hand.mesh(`links/${index}`);
      const geometry = geometryOf(mesh);
      const group = new Group();
      group.matrixAutoUpdate = false;
      const first = new Drawn(geometry, this.depthMaterial);
      first.renderOrder = order.handDepth;
      const drawn = new Drawn(geometry, this.material);
      drawn.renderOrder = order.hand;
      group.add(first, drawn);
      this.group.add(group);
      const pose = hand.description.X_SL[index];
      this.links.push({
        name: info.name,
        mesh,
        geometry,
        group,
        drawn,
        X_SL: pose === undefined ? new Matrix4() : matrixOf(pose),
        skinFaces: Uint32Array.from(facesOf[index] ?? []),
        skin: null,
      });
    });
  }

  pose(solution: PoseSolution): void {
    this.links.forEach((link, index) => {
      const X_WL = solution.X_WL[index];
      if (X_WL === undefined) return;
      link.group.matrix.copy(matrixOf(X_WL));
    });
    this.group.updateMatrixWorld(true);
  }

  setOpacity(opacity: number): void {
    this.material.opacity = opacity;
    this.material.transparent = opacity < 1;
  }

  link(name: string): LinkBody | undefined {
    return this.links.find((one) => one.name === name);
  }

  /** The link under the pointer, and where. */
  pickLink(caster: Raycaster): { link: LinkBody; p_W: Vector3; p_L: Vector3 } | null {
    let best: { link: LinkBody; p_W: Vector3; p_L: Vector3 } | null = null;
    let nearest = Infinity;
    for (const link of this.links) {
      if (link.mesh.triangles.length === 0) continue;
      const hit = hitOn(link.geometry, link.group.matrix, caster.ray);
      if (hit === null) continue;
      const p_W = hit.p.clone().applyMatrix4(link.group.matrix);
      const distance = p_W.distanceTo(caster.ray.origin);
      if (distance >= nearest) continue;
      nearest = distance;
      best = { link, p_W, p_L: hit.p.clone() };
    }
    return best;
  }

  /** Where every link is now. */
  poses(): Matrix4[] {
    return this.links.map((link) => link.group.matrix.clone());
  }

  /** The place of the posed skin under the pointer; `posed` is another pose than the one that is drawn. */
  pick(caster: Raycaster, posed?: Matrix4[]): Pick | null {
    let best: Pick | null = null;
    let nearest = Infinity;
    for (const [index, link] of this.links.entries()) {
      if (link.skinFaces.length === 0) continue;
      link.skin ??= this.partOf(link);
      const X_WS = this.skinPose(link, posed?.[index]);
      const hit = hitOn(link.skin, X_WS, caster.ray);
      if (hit === null) continue;
      const p_W = hit.p.clone().applyMatrix4(X_WS);
      const distance = p_W.distanceTo(caster.ray.origin);
      if (distance >= nearest) continue;
      nearest = distance;
      const face = link.skinFaces[hit.face]!;
      best = {
        root: surfacePoint(this.skin, face, hit.p),
        p_W,
        n_W: normalOf(this.skin, face).transformDirection(X_WS),
      };
    }
    return best;
  }

  /** The place of the posed skin that is nearest to a point. */
  nearest(p_W: Vector3): Pick | null {
    let best: Pick | null = null;
    let nearest = Infinity;
    for (const link of this.links) {
      if (link.skinFaces.length === 0) continue;
      link.skin ??= this.partOf(link);
      const X_WS = this.skinPose(link);
      const hit = treeOf(link.skin).closestPointToPoint(p_W.clone().applyMatrix4(X_WS.clone().invert()), undefined, 0, nearest);
      if (hit === null || hit.distance >= nearest) continue;
      nearest = hit.distance;
      const face = link.skinFaces[hit.faceIndex]!;
      best = {
        root: surfacePoint(this.skin, face, hit.point),
        p_W: hit.point.clone().applyMatrix4(X_WS),
        n_W: normalOf(this.skin, face).transformDirection(X_WS),
      };
    }
    return best;
  }

  /** Where a place on the skin is on the posed hand; null where no link carries it. */
  place(root: SurfacePoint): { p_W: Vector3; n_W: Vector3; X_W: Matrix4 } | null {
    const link = this.links[this.faceLinks[root.face] ?? -1];
    if (link === undefined) return null;
    const X_WS = this.skinPose(link);
    return {
      p_W: positionOf(this.skin, root).applyMatrix4(X_WS),
      n_W: normalOf(this.skin, root.face).transformDirection(X_WS),
      X_W: X_WS,
    };
  }

  box(): Box3 {
    return new Box3().setFromObject(this.group);
  }

  dispose(): void {
    for (const link of this.links) {
      link.geometry.dispose();
      link.skin?.dispose();
    }
    this.material.dispose();
    this.depthMaterial.dispose();
  }

  private skinPose(link: LinkBody, X_WL = link.group.matrix): Matrix4 {
    return X_WL.clone().multiply(link.X_SL.clone().invert());
  }

  private partOf(link: LinkBody): BufferGeometry {
    const triangles = new Uint32Array(3 * link.skinFaces.length);
    link.skinFaces.forEach((face, i) => triangles.set(this.skin.triangles.subarray(3 * face, 3 * face + 3), 3 * i));
    return pickingGeometry(this.skin.vertices, triangles);
  }
}

export const ghostColors = { pose: '#7b61c9', measured: '#00856f' };

/** The hand elsewhere, as a shell of light. */
export class Ghost {
  readonly group = new Group();
  private readonly material: MeshBasicMaterial;
  private readonly drawn: Drawn[];

  constructor(hand: HandBody, color: string) {
    this.material = new MeshBasicMaterial({ color, transparent: true, opacity: 0.28, side: BackSide, depthWrite: false });
    this.drawn = hand.links.map((link) => {
      const drawn = new Drawn(link.geometry, this.material);
      drawn.matrixAutoUpdate = false;
      drawn.renderOrder = order.marks - 1;
      return drawn;
    });
    this.group.add(...this.drawn);
  }

  pose(X_WL: Matrix4[]): void {
    this.drawn.forEach((drawn, index) => {
      const X = X_WL[index];
      drawn.visible = X !== undefined;
      if (X !== undefined) drawn.matrix.copy(X);
    });
    this.group.updateMatrixWorld(true);
  }

  dispose(): void {
    this.material.dispose();
  }
}
