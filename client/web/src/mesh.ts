// From a message's meshes to what is drawn and picked.

import { BufferAttribute, BufferGeometry, Matrix4, Quaternion, Vector3 } from 'three';
import { MeshBVH, acceleratedRaycast } from 'three-mesh-bvh';
import type { Mesh, Pose, SurfacePoint } from './wire';

export { acceleratedRaycast };

const kCreaseCosine = Math.cos((38 * Math.PI) / 180);

export function matrixOf(pose: Pose): Matrix4 {
  const [w, x, y, z] = pose.q_wxyz;
  return new Matrix4().compose(
    new Vector3(...pose.p_m),
    new Quaternion(x, y, z, w).normalize(),
    new Vector3(1, 1, 1),
  );
}

export function poseOf(X: Matrix4): Pose {
  const p = new Vector3();
  const q = new Quaternion();
  X.decompose(p, q, new Vector3());
  return { p_m: [p.x, p.y, p.z], q_wxyz: [q.w, q.x, q.y, q.z] };
}

/** Of each vertex the first one at its place: faces of many files share none. */
function welded(vertices: Float32Array): Uint32Array {
  const count = vertices.length / 3;
  const bits = new Int32Array(vertices.buffer, vertices.byteOffset, vertices.length);
  const size = 2 ** Math.ceil(Math.log2(2 * count + 2));
  const table = new Int32Array(size).fill(-1);
  const first = new Uint32Array(count);
  for (let i = 0; i < count; ++i) {
    let hash = Math.imul(bits[3 * i]!, 73856093) ^ Math.imul(bits[3 * i + 1]!, 19349663);
    hash = (hash ^ Math.imul(bits[3 * i + 2]!, 83492791)) >>> 0;
    let slot = (hash ^ (hash >>> 15)) & (size - 1);
    while (table[slot]! >= 0) {
      const j = table[slot]!;
      if (
        bits[3 * j] === bits[3 * i] &&
        bits[3 * j + 1] === bits[3 * i + 1] &&
        bits[3 * j + 2] === bits[3 * i + 2]
      )
        break;
      slot = (slot + 1) & (size - 1);
    }
    if (table[slot]! < 0) table[slot] = i;
    first[i] = table[slot]!;
  }
  return first;
}

/**
 * Smooth where the surface is, sharp at its edges. Faces keep their order.
 */
export function geometryOf(mesh: Mesh): BufferGeometry {
  const { vertices, triangles } = mesh;
  const corners = triangles.length;
  const faces = corners / 3;
  const first = welded(vertices);

  // === Faces' normals, as long as their areas
  const normals = new Float32Array(3 * faces);
  const units = new Float32Array(3 * faces);
  for (let i = 0; i < corners; i += 3) {
    const a = 3 * triangles[i]!, b = 3 * triangles[i + 1]!, c = 3 * triangles[i + 2]!;
    const ux = vertices[b]! - vertices[a]!, uy = vertices[b + 1]! - vertices[a + 1]!, uz = vertices[b + 2]! - vertices[a + 2]!;
    const vx = vertices[c]! - vertices[a]!, vy = vertices[c + 1]! - vertices[a + 1]!, vz = vertices[c + 2]! - vertices[a + 2]!;
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    normals[i] = x;
    normals[i + 1] = y;
    normals[i + 2] = z;
    units[i] = x / length;
    units[i + 1] = y / length;
    units[i + 2] = z / length;
  }

  // === The faces about each place
  const begin = new Uint32Array(first.length + 1);
  for (let i = 0; i < corners; ++i) ++begin[first[triangles[i]!]! + 1]!;
  for (let i = 0; i < first.length; ++i) begin[i + 1]! += begin[i]!;
  const next = begin.slice();
  const about = new Uint32Array(corners);
  for (let i = 0; i < corners; ++i) about[next[first[triangles[i]!]!]!++] = (i / 3) | 0;

  // === Each corner's; corners at one place with one normal are one vertex
  const kSame = 1e-4;
  const position = new Float32Array(3 * corners); // as many as there may be
  const normal = new Float32Array(3 * corners);
  const source = new Uint32Array(corners); // the mesh's vertex that each is a copy of
  const newest = new Int32Array(first.length).fill(-1); // of the vertices made at each place
  const older = new Int32Array(corners);
  const index = new Uint32Array(corners);
  let count = 0;
  for (let i = 0; i < corners; ++i) {
    const f = (i / 3) | 0;
    const vertex = triangles[i]!;
    const place = first[vertex]!;
    let x = 0, y = 0, z = 0;
    const nx = units[3 * f]!, ny = units[3 * f + 1]!, nz = units[3 * f + 2]!;
    for (let k = begin[place]!; k < begin[place + 1]!; ++k) {
      const g = 3 * about[k]!;
      if (nx * units[g]! + ny * units[g + 1]! + nz * units[g + 2]! < kCreaseCosine) continue;
      x += normals[g]!;
      y += normals[g + 1]!;
      z += normals[g + 2]!;
    }
    const length = Math.sqrt(x * x + y * y + z * z);
    if (length > 0) {
      x /= length;
      y /= length;
      z /= length;
    } else {
      x = nx;
      y = ny;
      z = nz;
    }
    let made = newest[place]!;
    while (made >= 0 && Math.abs(normal[3 * made]! - x) + Math.abs(normal[3 * made + 1]! - y) + Math.abs(normal[3 * made + 2]! - z) > kSame) {
      made = older[made]!;
    }
    if (made < 0) {
      made = count++;
      source[made] = vertex;
      for (let k = 0; k < 3; ++k) position[3 * made + k] = vertices[3 * vertex + k]!;
      normal[3 * made] = x;
      normal[3 * made + 1] = y;
      normal[3 * made + 2] = z;
      older[made] = newest[place]!;
      newest[place] = made;
    }
    index[i] = made;
  }

  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(position.slice(0, 3 * count), 3));
  geometry.setAttribute('normal', new BufferAttribute(normal.slice(0, 3 * count), 3));
  geometry.setIndex(new BufferAttribute(index, 1));
  geometry.userData['source'] = source.slice(0, count);
  return geometry;
}

/** Colours of the mesh's vertices, as the geometry made of it has them. */
export function paint(geometry: BufferGeometry, colors: Float32Array): void {
  const source = geometry.userData['source'] as Uint32Array;
  const had = geometry.attributes['color'] as BufferAttribute | undefined;
  const attribute = had ?? new BufferAttribute(new Float32Array(3 * source.length), 3);
  source.forEach((vertex, i) => attribute.array.set(colors.subarray(3 * vertex, 3 * vertex + 3), 3 * i));
  attribute.needsUpdate = true;
  if (had === undefined) geometry.setAttribute('color', attribute);
}

/** The same faces, for picking alone. */
export function pickingGeometry(vertices: Float32Array, triangles: Uint32Array): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(vertices, 3));
  geometry.setIndex(new BufferAttribute(triangles, 1));
  return geometry;
}

/** Rays and nearest points in logarithmic time; faces keep their numbers. Made when it is first needed. */
export function treeOf(geometry: BufferGeometry): MeshBVH {
  geometry.boundsTree ??= new MeshBVH(geometry, { indirect: true });
  return geometry.boundsTree as MeshBVH;
}

const kA = new Vector3();
const kB = new Vector3();
const kC = new Vector3();

function cornersOf(mesh: Mesh, face: number): [Vector3, Vector3, Vector3] {
  const { vertices, triangles } = mesh;
  kA.fromArray(vertices, 3 * triangles[3 * face]!);
  kB.fromArray(vertices, 3 * triangles[3 * face + 1]!);
  kC.fromArray(vertices, 3 * triangles[3 * face + 2]!);
  return [kA, kB, kC];
}

export function positionOf(mesh: Mesh, point: SurfacePoint): Vector3 {
  const [a, b, c] = cornersOf(mesh, point.face);
  const [u, v, w] = point.barycentric;
  return new Vector3().addScaledVector(a, u).addScaledVector(b, v).addScaledVector(c, w);
}

export function normalOf(mesh: Mesh, face: number): Vector3 {
  const [a, b, c] = cornersOf(mesh, face);
  return b.clone().sub(a).cross(c.clone().sub(a)).normalize();
}

/** The place on that face that is nearest to `p`, which lies on it but for rounding. */
export function surfacePoint(mesh: Mesh, face: number, p: Vector3): SurfacePoint {
  const [a, b, c] = cornersOf(mesh, face);
  const u = b.clone().sub(a), v = c.clone().sub(a), w = p.clone().sub(a);
  const uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), wu = w.dot(u), wv = w.dot(v);
  const det = uu * vv - uv * uv || 1;
  const s = Math.max(0, (vv * wu - uv * wv) / det);
  const t = Math.max(0, (uu * wv - uv * wu) / det);
  const sum = Math.max(1, s + t);
  return { face, barycentric: [1 - (s + t) / sum, s / sum, t / sum] };
}
