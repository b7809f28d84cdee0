// Lines some pixels wide, many in one call.

import { Color, Group } from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import type { InterleavedBufferAttribute } from 'three';
import { order } from './bodies';

interface Options {
  width: number;
  opacity?: number;
  dashed?: boolean;
}

/** Drawn twice: among what the hand shows through, and crisp where nothing is in front. */
export class Lines {
  readonly group = new Group();
  private geometry = new LineSegmentsGeometry();
  private count = -1;
  private readonly behind: LineMaterial;
  private readonly front: LineMaterial;

  constructor(options: Options) {
    const of = (transparent: boolean) =>
      new LineMaterial({
        linewidth: options.width,
        vertexColors: true,
        transparent,
        opacity: options.opacity ?? 1,
        depthWrite: false,
        polygonOffset: true,
        polygonOffsetFactor: -4,
        polygonOffsetUnits: -8,
      });
    this.behind = of(false);
    this.front = of(true);
  }

  get length(): number {
    return Math.max(0, this.count);
  }

  /** Segments, two points each, and a colour a segment. */
  set(points: number[], colors: Color[]): void {
    const segments = colors.length;
    if (segments !== this.count) this.make(segments);
    if (segments === 0) return;
    const write = (name: string, values: ArrayLike<number>) => {
      const buffer = (this.geometry.attributes[name] as InterleavedBufferAttribute).data;
      buffer.set(values, 0);
      buffer.needsUpdate = true;
    };
    write('instanceStart', points);
    const both = new Float32Array(6 * segments);
    colors.forEach((color, i) => {
      color.toArray(both, 6 * i);
      color.toArray(both, 6 * i + 3);
    });
    write('instanceColorStart', both);
  }

  dispose(): void {
    this.geometry.dispose();
    this.behind.dispose();
    this.front.dispose();
  }

  private make(segments: number): void {
    this.geometry.dispose();
    this.group.clear();
    this.count = segments;
    if (segments === 0) return;
    this.geometry = new LineSegmentsGeometry();
    this.geometry.setPositions(new Float32Array(6 * segments));
    this.geometry.setColors(new Float32Array(6 * segments));
    const behind = new LineSegments2(this.geometry, this.behind);
    const front = new LineSegments2(this.geometry, this.front);
    front.renderOrder = order.marks;
    for (const lines of [behind, front]) {
      lines.frustumCulled = false; // it moves with every pose
      this.group.add(lines);
    }
  }
}
