// Where the links of a hand are for joints that the server has posed nobody in: for ghosts of other minima and of the
// measured hand. Poses that are edited come from the server; this agrees with them or is not used.

import { Euler, Matrix4, Quaternion, Vector3 } from 'three';
import { matrixOf } from './mesh';
import type { HandDescription, Pose, PoseSolution } from './wire';

interface Joint {
  name: string;
  type: string;
  parent: string;
  X_PJ: Matrix4; // of the joint in its parent, at zero
  axis: Vector3;
  mimic: { joint: string; multiplier: number; offset: number } | null;
}

const kAgree_m = 1e-4;

function numbers(text: string | null | undefined, otherwise: number[]): number[] {
  const found = (text ?? '').trim().split(/\s+/).map(Number);
  return found.length === otherwise.length && found.every(Number.isFinite) ? found : otherwise;
}

function jointOf(element: Element): [string, Joint] {
  const at = (tag: string, name: string) => element.querySelector(`:scope > ${tag}`)?.getAttribute(name) ?? null;
  const [x, y, z] = numbers(at('origin', 'xyz'), [0, 0, 0]) as [number, number, number];
  const [roll, pitch, yaw] = numbers(at('origin', 'rpy'), [0, 0, 0]) as [number, number, number];
  const turn = new Quaternion().setFromEuler(new Euler(roll, pitch, yaw, 'ZYX')); // about fixed axes x, y, z
  const mimicked = at('mimic', 'joint');
  const joint: Joint = {
    name: element.getAttribute('name') ?? '',
    type: element.getAttribute('type') ?? 'fixed',
    parent: at('parent', 'link') ?? '',
    X_PJ: new Matrix4().compose(new Vector3(x, y, z), turn, new Vector3(1, 1, 1)),
    axis: new Vector3().fromArray(numbers(at('axis', 'xyz'), [1, 0, 0])).normalize(),
    mimic:
      mimicked === null
        ? null
        : { joint: mimicked, multiplier: numbers(at('mimic', 'multiplier'), [1])[0]!, offset: numbers(at('mimic', 'offset'), [0])[0]! },
  };
  return [at('child', 'link') ?? '', joint];
}

export class Kinematics {
  private readonly above: Map<string, Joint>; // by the link that each moves

  constructor(private readonly hand: HandDescription) {
    const robot = new DOMParser().parseFromString(hand.urdf, 'application/xml');
    this.above = new Map([...robot.querySelectorAll('robot > joint')].map(jointOf));
  }

  /** Of every link in the world; null for what this does not understand. */
  poses(X_WH: Pose, positions: Map<string, number>): Matrix4[] | null {
    const known = new Map<string, Matrix4>([[this.hand.links[0]?.name ?? '', matrixOf(X_WH)]]);
    const find = (link: string, depth: number): Matrix4 | null => {
      const found = known.get(link);
      if (found !== undefined) return found;
      const joint = this.above.get(link);
      if (joint === undefined || depth > this.hand.links.length) return null;
      const X_WP = find(joint.parent, depth + 1);
      if (X_WP === null) return null;
      const X_WL = X_WP.clone().multiply(joint.X_PJ).multiply(this.moved(joint, positions));
      known.set(link, X_WL);
      return X_WL;
    };
    const all = this.hand.links.map((link) => find(link.name, 0));
    return all.every((one) => one !== null) ? all : null;
  }

  /** True where it puts the links where the server does. */
  agrees(solution: PoseSolution, joints: string[]): boolean {
    const mine = this.poses(solution.X_WH, positionsOf(joints, solution.joint_positions));
    return (
      mine !== null &&
      mine.every((X_WL, link) => {
        const other = solution.X_WL[link];
        // A point off the origin sees turns, too.
        const p = new Vector3(0.05, 0.05, 0.05);
        return other !== undefined && p.clone().applyMatrix4(X_WL).distanceTo(p.applyMatrix4(matrixOf(other))) < kAgree_m;
      })
    );
  }

  private moved(joint: Joint, positions: Map<string, number>): Matrix4 {
    const { mimic } = joint;
    const q = mimic === null ? (positions.get(joint.name) ?? 0) : mimic.multiplier * (positions.get(mimic.joint) ?? 0) + mimic.offset;
    if (joint.type === 'revolute' || joint.type === 'continuous') return new Matrix4().makeRotationAxis(joint.axis, q);
    if (joint.type === 'prismatic') return new Matrix4().setPosition(joint.axis.clone().multiplyScalar(q));
    return new Matrix4();
  }
}

export const positionsOf = (names: string[], positions: number[]): Map<string, number> =>
  new Map(names.map((name, i) => [name, positions[i] ?? 0]));
