// What an edit of a motion holds for: about the time that is shown, or all of it.

import { Matrix4 } from 'three';
import { matrixOf, poseOf } from './mesh';
import type { Session } from './session';
import type { DragBody, EditBody, EditTime } from './wire';

/** What may hold about a time of a motion. */
const kTimed = new Set(['patch_root', 'patch_direction', 'patch_enabled', 'patch_weight', 'joint_limit', 'joint_lock', 'joint_soft', 'drag']);

/** An edit made while that time is shown, and about which time of the motion it holds; null: all of it, or there is none. */
export function aimed(session: Session, body: EditBody, time_s: number): [EditBody, EditTime | null] {
  if (session.motion === null || !kTimed.has(body.kind)) return [body, null];
  if (session.reach_s !== null) {
    const drag = body['drag'] as DragBody | undefined;
    // A place is moved; links are not turned at a time.
    const there = drag === undefined ? body : { ...body, drag: { ...drag, target_q_wxyz: [] } };
    return [there, { time_s, falloff_s: session.reach_s }];
  }
  if (body.kind === 'drag') return [inGrasp(session, body, time_s), null];
  return [body, null];
}

/** A drag for all of the motion, told where the session has the object, not where the motion has it then. */
function inGrasp(session: Session, body: EditBody, time_s: number): EditBody {
  const drag = body['drag'] as DragBody;
  const X_WO = session.settings?.X_WO;
  if (X_WO === undefined) return body;
  const X = matrixOf(X_WO).multiply(matrixOf(session.motion!.at(time_s, session.id).X_WO).invert());
  const [w, x, y, z] = drag.target_q_wxyz;
  const isTurned = w !== undefined;
  const target = new Matrix4().multiplyMatrices(X, matrixOf({
    p_m: drag.target_W_m as [number, number, number],
    q_wxyz: isTurned ? [w, x!, y!, z!] : [1, 0, 0, 0],
  }));
  const { p_m, q_wxyz } = poseOf(target);
  return { ...body, drag: { ...drag, target_W_m: p_m, target_q_wxyz: isTurned ? q_wxyz : [] } };
}

/** Of the edits at times, the last with one of these texts (the server's) that holds then. */
export function editedAt(session: Session, time_s: number, texts: string[]): string | null {
  const covers = (one: EditTime) => Math.abs(one.time_s - time_s) <= Math.max(one.falloff_s / 2, 1e-6);
  const found = (session.settings?.timed ?? []).filter((one) => texts.includes(one.text) && covers(one));
  return found.at(-1)?.text ?? null;
}
