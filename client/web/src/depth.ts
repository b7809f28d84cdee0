// How deep the hand lies in the object, on its surface. Worked out between pictures, a little at a time.

import { BufferAttribute, BufferGeometry, Color, DoubleSide, Matrix4, Mesh as Drawn, MeshBasicMaterial, Ray, Vector3 } from 'three';
import { order, type HandBody, type LinkBody, type ObjectBody } from './bodies';
import { depthColor } from './colors';
import { paint, treeOf } from './mesh';
import type { PoseSolution } from './wire';

const kSlice_ms = 6;
const kLookedFor_m = 0.03; // deeper is drawn as this

export class DepthShade {
  private job = 0;
  /** What lies inside, seen through the object that hides it. */
  private readonly inside = new Map<LinkBody, Drawn>();
  private readonly through = new MeshBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.8, side: DoubleSide, depthTest: false, depthWrite: false });

  constructor(
    private readonly hand: HandBody,
    private readonly object: ObjectBody,
    private readonly redraw: () => void,
  ) {}

  /** Paints the links that the report says lie inside; `shown` false: none. */
  update(solution: PoseSolution, shown: boolean): void {
    ++this.job;
    const deep = new Set(shown ? (solution.penetration?.links ?? []).map((one) => one.link) : []);
    for (const link of this.hand.links) if (!deep.has(link.name)) this.clear(link);
    const todo = this.hand.links.filter((link) => deep.has(link.name) && link.mesh.triangles.length > 0);
    if (todo.length > 0) void this.paint(this.job, todo);
  }

  dispose(): void {
    ++this.job;
    for (const link of [...this.inside.keys()]) this.hideInside(link);
    this.through.dispose();
  }

  private showInside(link: LinkBody, shade: Float32Array, isDeep: Uint8Array): void {
    this.hideInside(link);
    const { triangles, vertices } = link.mesh;
    const index: number[] = [];
    for (let i = 0; i + 2 < triangles.length; i += 3) {
      const face = [triangles[i]!, triangles[i + 1]!, triangles[i + 2]!];
      if (face.every((vertex) => isDeep[vertex] === 1)) index.push(...face);
    }
    if (index.length === 0) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(vertices, 3));
    geometry.setAttribute('color', new BufferAttribute(shade, 3));
    geometry.setIndex(index);
    const drawn = new Drawn(geometry, this.through);
    drawn.renderOrder = order.hand + 1;
    drawn.raycast = () => undefined; // nobody takes hold of it
    link.group.add(drawn);
    this.inside.set(link, drawn);
  }

  private hideInside(link: LinkBody): void {
    const drawn = this.inside.get(link);
    if (drawn === undefined) return;
    link.group.remove(drawn);
    drawn.geometry.dispose();
    this.inside.delete(link);
  }

  private clear(link: LinkBody): void {
    this.hideInside(link);
    if (link.drawn.material === this.hand.material) return;
    const painted = link.drawn.material as typeof this.hand.material;
    painted.dispose();
    link.drawn.material = this.hand.material;
    this.redraw();
  }

  private async paint(job: number, links: LinkBody[]): Promise<void> {
    await new Promise((resolve) => setTimeout(resolve)); // the picture first
    if (job !== this.job) return;
    const plain = this.hand.material.color;
    const tree = treeOf(this.object.geometry);
    for (const link of links) {
      const X_OL = this.object.X_WO.clone().invert().multiply(link.group.matrix);
      const { vertices } = link.mesh;
      const shade = new Float32Array(vertices.length);
      const isDeep = new Uint8Array(vertices.length / 3);
      let begun = performance.now();
      for (let i = 0; i < vertices.length / 3; ++i) {
        const color = this.colorAt(tree, X_OL, vertices, i, plain);
        color.toArray(shade, 3 * i);
        if (color !== plain) isDeep[i] = 1;
        if (performance.now() - begun < kSlice_ms) continue;
        await new Promise((resolve) => setTimeout(resolve));
        if (job !== this.job) return;
        begun = performance.now();
      }
      paint(link.geometry, shade);
      this.showInside(link, shade, isDeep);
      if (link.drawn.material === this.hand.material) {
        const painted = this.hand.material.clone();
        painted.color = new Color('#ffffff');
        painted.vertexColors = true;
        painted.opacity = Math.max(0.85, this.hand.material.opacity);
        link.drawn.material = painted;
      }
      this.redraw();
    }
  }

  private colorAt(tree: ReturnType<typeof treeOf>, X_OL: Matrix4, vertices: Float32Array, i: number, plain: Color): Color {
    const p = new Vector3().fromArray(vertices, 3 * i).applyMatrix4(X_OL);
    const nearest = tree.closestPointToPoint(p, undefined, 0, kLookedFor_m);
    if (nearest === null) return plain;
    // Inside: an odd number of walls in a direction; two that agree, since meshes have holes.
    const isInside = [new Vector3(0.31, 0.27, 0.91), new Vector3(-0.72, 0.55, -0.42)].every(
      (direction) => tree.raycast(new Ray(p, direction.normalize()), DoubleSide).length % 2 === 1,
    );
    return isInside ? depthColor(nearest.distance) : plain;
  }
}
