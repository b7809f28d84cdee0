// What is drawn when it is asked for: the hand's sites, normals where contacts meet, points that found no place on the hand.

import { CanvasTexture, Color, Group, Sprite, SpriteMaterial, Vector3 } from 'three';
import { order, type HandBody, type ObjectBody } from './bodies';
import { sketch } from './dom';
import { Lines } from './lines';
import type { HandDescription, PatchInfo, PatchReport, PoseSolution } from './wire';

const kNormal_m = 0.008;
const kCross_m = 0.0015;
const kLost = new Color('#b3261e');

export interface Details {
  sites: boolean;
  normals: boolean;
  lost: boolean;
}

function label(text: string): CanvasTexture {
  const draw = sketch(1, 48);
  const { canvas } = draw;
  const font = '600 34px system-ui, sans-serif';
  draw.font = font;
  canvas.width = Math.ceil(draw.measureText(text).width) + 60;
  draw.font = font;
  draw.beginPath();
  draw.roundRect(34, 2, canvas.width - 36, 44, 10);
  draw.fillStyle = 'rgba(255,255,255,0.85)';
  draw.fill();
  draw.fillStyle = '#1d2024';
  draw.textBaseline = 'middle';
  draw.fillText(text, 44, 25);
  draw.beginPath();
  draw.arc(14, 24, 11, 0, 2 * Math.PI);
  draw.fillStyle = '#1d2024';
  draw.fill();
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = 'srgb';
  return texture;
}

export class DetailMarks {
  readonly group = new Group();
  private readonly normals = new Lines({ width: 1.6 });
  private readonly lost = new Lines({ width: 2.4 });
  private readonly sites: { sprite: Sprite; link: number; p_L: Vector3; aspect: number }[] = [];

  constructor(
    private readonly hand: HandDescription,
    private readonly colorOf: (patch: string) => string,
  ) {
    this.group.add(this.normals.group, this.lost.group);
  }

  show(solution: PoseSolution, reports: PatchReport[], patches: PatchInfo[], object: ObjectBody, hand: HandBody, shown: Details): void {
    this.showSites(hand, shown.sites);
    this.showNormals(solution, object, hand, shown.normals);
    this.showLost(reports, patches, object, shown.lost);
  }

  /** As large on the screen, whatever the distance. */
  size(perPixel: number): void {
    for (const { sprite, aspect } of this.sites) sprite.scale.set(18 * aspect * perPixel, 18 * perPixel, 1);
  }

  /** How many of each are seen. */
  facts(): Record<string, number> {
    return { sites: this.sites.filter(({ sprite }) => sprite.visible).length, normals: this.normals.length, lost: this.lost.length / 4 };
  }

  dispose(): void {
    this.normals.dispose();
    this.lost.dispose();
    for (const { sprite } of this.sites) {
      sprite.material.map?.dispose();
      sprite.material.dispose();
    }
  }

  private showSites(hand: HandBody, isShown: boolean): void {
    if (isShown && this.sites.length === 0) {
      for (const site of this.hand.sites) {
        const map = label(site.name);
        const { width, height } = map.image as HTMLCanvasElement;
        const sprite = new Sprite(new SpriteMaterial({ map, sizeAttenuation: false, depthTest: false, transparent: true }));
        sprite.center.set(14 / width, 0.5);
        sprite.renderOrder = order.marks + 1;
        this.sites.push({ sprite, link: hand.links.findIndex((link) => link.name === site.link), p_L: new Vector3(...site.p_L_m), aspect: width / height });
        this.group.add(sprite);
      }
    }
    for (const { sprite, link, p_L } of this.sites) {
      const on = hand.links[link];
      sprite.visible = isShown && on !== undefined;
      if (on !== undefined) sprite.position.copy(p_L).applyMatrix4(on.group.matrix);
    }
  }

  /** Of the surfaces, at the points that should meet: outward on both. */
  private showNormals(solution: PoseSolution, object: ObjectBody, hand: HandBody, isShown: boolean): void {
    const points: number[] = [];
    const colors: Color[] = [];
    for (const fit of isShown ? solution.patches : []) {
      const color = new Color(this.colorOf(fit.name));
      for (const [at, body] of [[fit.hand_W_m, hand], [fit.object_W_m, object]] as const) {
        for (let i = 0; i + 2 < at.length; i += 3) {
          const on = body.nearest(new Vector3().fromArray(at, i));
          if (on === null) continue;
          points.push(...on.p_W.toArray(), ...on.p_W.clone().addScaledVector(on.n_W, kNormal_m).toArray());
          colors.push(color);
        }
      }
    }
    this.normals.set(points, colors);
  }

  /** Crosses on the object. */
  private showLost(reports: PatchReport[], patches: PatchInfo[], object: ObjectBody, isShown: boolean): void {
    const points: number[] = [];
    const colors: Color[] = [];
    for (const report of isShown ? reports : []) {
      const outline = patches.find((patch) => patch.name === report.name)?.outline_O_m ?? [];
      for (const { index, ring } of report.lost) {
        if (ring !== 0 || 3 * index + 2 >= outline.length) continue; // those inside have no place that is told
        const p_W = new Vector3().fromArray(outline, 3 * index).applyMatrix4(object.X_WO);
        for (const [x, y, z] of [[1, 1, 0], [1, -1, 0], [0, 1, 1], [0, 1, -1]] as const) {
          const arm = new Vector3(x, y, z).multiplyScalar(kCross_m);
          points.push(...p_W.clone().add(arm).toArray(), ...p_W.clone().sub(arm).toArray());
          colors.push(kLost);
        }
      }
    }
    this.lost.set(points, colors);
  }
}
