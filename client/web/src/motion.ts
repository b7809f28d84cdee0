// A hand that followed a motion: its frames, and what stands between two of them.

import { Quaternion, Vector3 } from 'three';
import { Refusal, type Link } from './link';
import type { MotionDescription, MotionFrame, MotionFrames, Pose, PoseSolution } from './wire';

const kMostFrames = 600; // of longer motions every second, fourth, ... one is shown
const kFine = 60; // but of those to either side of the time that is shown, by their index, all
const kAtOnce = 60; // in one answer
/** Presence from which on a patch is there. */
export const kIsThere = 0.5;

/** Keeps to the range [0, 1]. */
const share = (value: number) => Math.min(1, Math.max(0, value));

function poseBetween(a: Pose, b: Pose, at: number): Pose {
  const p = new Vector3().fromArray(a.p_m).lerp(new Vector3().fromArray(b.p_m), at);
  const turn = ([w, x, y, z]: Pose['q_wxyz']) => new Quaternion(x, y, z, w);
  const q = turn(a.q_wxyz).slerp(turn(b.q_wxyz), at);
  return { p_m: [p.x, p.y, p.z], q_wxyz: [q.w, q.x, q.y, q.z] };
}

/** Between those of two frames, where they are the same points. */
function pointsBetween(a: number[], b: number[], at: number): number[] {
  return at === 0 || a.length !== b.length ? a : a.map((x, i) => x + at * (b[i]! - x));
}

/** Points of a frame in the world. */
function inWorld(X: Pose, points: number[]): number[] {
  const [w, x, y, z] = X.q_wxyz;
  const turn = new Quaternion(x, y, z, w);
  const by = new Vector3().fromArray(X.p_m);
  const moved: number[] = [];
  for (let i = 0; i + 2 < points.length; i += 3) {
    moved.push(...new Vector3().fromArray(points, i).applyQuaternion(turn).add(by).toArray());
  }
  return moved;
}

/** What a patch had before, for as long as its new outline is not known. */
function withShapesOf(frame: MotionFrame, before: MotionFrame): MotionFrame {
  const patches = frame.patches.map((patch) => {
    const same = before.patches.find((one) => one.patch === patch.patch);
    return { ...patch, outline_O_m: same?.outline_O_m ?? [], hand_W_m: [] };
  });
  return { ...frame, patches };
}

function inOrder(frames: Map<number, MotionFrame>): MotionFrame[] {
  return [...frames.values()].sort((a, b) => a.index - b.index);
}

export class Motion {
  /** As they are shown: also those of an answer that is not complete yet. */
  frames: MotionFrame[];
  /** By index: the outlines are older than the frame. */
  readonly unshaped = new Set<number>();
  private shown: number; // the revision of the newest
  /** Those of which all are here, by index. */
  private fine = { from: 0, end: 0 };

  constructor(
    readonly description: MotionDescription,
    private answered: MotionFrame[],
    public revision: number,
    /** Of the motion's frames that many-th is here, a power of two; and between them those that are fine. */
    readonly every = 1,
  ) {
    this.frames = answered;
    this.shown = revision;
  }

  /** Frames that a solve has so far: in place of the answer's until that is complete. */
  preview(revision: number, frames: MotionFrame[]): void {
    if (revision < this.revision) return;
    this.shown = revision;
    const all = new Map(this.answered.map((frame) => [frame.index, frame]));
    let before = this.answered[0];
    for (const frame of frames) {
      before = all.get(frame.index) ?? before;
      if (before === undefined || !this.isShown(frame.index)) continue;
      this.unshaped.add(frame.index);
      all.set(frame.index, withShapesOf(frame, before));
    }
    this.frames = inOrder(all);
  }

  /** What is shown answers that revision, of which every so many-th frame was told. */
  complete(revision: number, every = 1): void {
    if (every > 1) this.coarsen();
    this.answered = this.frames;
    this.revision = this.shown = revision;
  }

  /** Which frames to ask for, so that all about that time are here; null: they are. */
  missingAt(time_s: number): { first: number; count: number } | null {
    const all = this.description.frame_count;
    const middle = this.frames[this.indexAt(time_s)]!.index;
    const from = Math.max(0, middle - kFine);
    const end = Math.min(all, middle + kFine + 1);
    // Not again for every step.
    const isThere = (index: number) => index < 0 || index > all - 1 || (index >= this.fine.from && index < this.fine.end);
    if (this.every === 1 || (isThere(middle - kFine / 2) && isThere(middle) && isThere(middle + kFine / 2))) return null;
    return { first: from, count: end - from };
  }

  /** All frames from there on, with their outlines, in place of those that were fine before. */
  refine(revision: number, frames: MotionFrame[]): void {
    const first = frames[0];
    if (first === undefined || revision !== this.revision || this.shown !== revision) return;
    this.coarsen();
    this.fine = { from: first.index, end: first.index + frames.length };
    const all = new Map(this.frames.map((frame) => [frame.index, frame]));
    for (const frame of frames) {
      all.set(frame.index, frame);
      this.unshaped.delete(frame.index);
    }
    this.answered = this.frames = inOrder(all);
  }

  private isShown(index: number): boolean {
    return index % this.every === 0 || (index >= this.fine.from && index < this.fine.end);
  }

  private coarsen(): void {
    this.fine = { from: 0, end: 0 };
    this.frames = this.frames.filter((frame) => frame.index % this.every === 0);
    for (const index of this.unshaped) if (index % this.every !== 0) this.unshaped.delete(index);
  }

  /** Frames with their outlines, of the answer that is shown. */
  shape(revision: number, frames: MotionFrame[]): void {
    if (revision !== this.revision || this.shown !== revision) return;
    const shaped = new Map(frames.map((frame) => [frame.index, frame]));
    this.answered = this.frames = this.frames.map((frame) => shaped.get(frame.index) ?? frame);
    for (const index of shaped.keys()) this.unshaped.delete(index);
  }

  /** The revision of the frames that are shown. */
  get newest(): number {
    return this.shown;
  }

  get duration_s(): number {
    return this.frames.at(-1)?.time_s ?? 0;
  }

  /** The last frame that has begun. */
  indexAt(time_s: number): number {
    let low = 0;
    let high = this.frames.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.frames[middle]!.time_s <= time_s) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** The hand at that time, with what is said of the frame before it. */
  at(time_s: number, session: number): PoseSolution {
    const index = this.indexAt(time_s);
    const a = this.frames[index]!;
    const b = this.frames[index + 1] ?? a;
    const at = b.time_s > a.time_s ? share((time_s - a.time_s) / (b.time_s - a.time_s)) : 0;
    const X_WO = poseBetween(a.X_WO, b.X_WO, at);
    return {
      session_id: session,
      revision: this.shown,
      sequence_number: a.index,
      outcome: 'converged',
      solver: '',
      X_WH: poseBetween(a.X_WH, b.X_WH, at),
      X_WO,
      joint_positions: a.joint_positions.map((q, i) => q + at * ((b.joint_positions[i] ?? q) - q)),
      X_WL: a.X_WL.map((X, i) => poseBetween(X, b.X_WL[i] ?? X, at)),
      terms: { distance_m2: 0, normal: 0, prior: 0, objective: 0 },
      // A patch comes while it goes elsewhere: what is there most stands for it, from half on.
      patches: [...a.patches].sort((one, other) => other.presence - one.presence).map((patch) => {
        const next = b.patches.find((one) => one.patch === patch.patch) ?? patch;
        return {
          name: this.description.patches[patch.patch] ?? String(patch.patch),
          point_count: patch.outline_O_m.length / 3,
          mean_mm: patch.mean_mm,
          max_mm: patch.mean_mm,
          normal_deg: patch.normal_deg,
          hand_W_m: pointsBetween(patch.hand_W_m, next.hand_W_m, at),
          object_W_m: inWorld(X_WO, pointsBetween(patch.outline_O_m, next.outline_O_m, at)),
          diagnosis: {
            verdict: patch.presence < kIsThere ? 'none' : patch.reached ? 'reached' : 'out_of_reach',
            text: patch.presence < 1 ? `comes or goes: ${Math.round(100 * patch.presence)} % there` : '',
          },
        };
      }),
      joints_at_limit: a.joints_at_limit,
      held: [],
      is_diagnosed: true,
      verdict: '',
      sensitivities: [],
      penetration: { max_depth_m: a.max_depth_m, volume_m3: 0, links: [], self_depth_m: a.self_depth_m },
      minima: [],
      chosen_minimum: 0,
      times: [],
    };
  }
}

/** Asks for the frames that the server has; who may edit has them solved where there are none. */
export async function fetchMotion(
  link: Link,
  session: number,
  description: MotionDescription,
  maySolve: boolean,
  onShare: (share: number) => void,
): Promise<Motion> {
  let every = 1;
  while (description.frame_count > every * kMostFrames) every *= 2; // as the gateway thins what it tells
  const ask = (first: number) =>
    link.ask<MotionFrames>({
      kind: 'motion_frames',
      motion_frames: { session_id: session, first, count: kAtOnce, every, with_shapes: true },
    });
  let answer: MotionFrames;
  try {
    answer = await ask(0);
  } catch (error) {
    if (!maySolve || !(error instanceof Refusal) || error.code === 'no_link' || error.code === 'no_server') throw error;
    await link.ask({ kind: 'solve_motion', solve_motion: { session_id: session, options: null } });
    answer = await ask(0);
  }
  for (;;) {
    const frames = [...answer.frames];
    const { revision, frame_count } = answer;
    while (frames.length > 0 && frames.length * every < frame_count) {
      onShare((frames.length * every) / frame_count);
      answer = await ask(frames.length * every);
      if (answer.frames.length === 0 || answer.revision !== revision) break;
      frames.push(...answer.frames);
    }
    if (answer.revision === revision) return new Motion(description, frames, revision, every);
    // Edited meanwhile: what came so far would be a motion that ends too early.
    answer = await ask(0);
  }
}

/** Asks for all frames about a time, where not all are here; true: there are more now. */
export async function fetchFine(link: Link, session: number, motion: Motion, time_s: number): Promise<boolean> {
  const missing = motion.missingAt(time_s);
  if (missing === null) return false;
  const { revision } = motion;
  const frames: MotionFrame[] = [];
  while (frames.length < missing.count) {
    const answer = await link.ask<MotionFrames>({
      kind: 'motion_frames',
      motion_frames: { session_id: session, first: missing.first + frames.length, count: Math.min(kAtOnce, missing.count - frames.length), every: 1, with_shapes: true },
    });
    if (answer.frames.length === 0 || answer.revision !== revision || motion.newest !== revision) return false;
    frames.push(...answer.frames);
  }
  motion.refine(revision, frames);
  return true;
}

/** Asks for the outlines of frames that were solved anew. */
export async function fetchShapes(link: Link, session: number, motion: Motion): Promise<void> {
  const { revision } = motion;
  const wanted = [...motion.unshaped].sort((a, b) => a - b);
  for (let i = 0; i < wanted.length; ) {
    const every = Math.min(motion.every, (wanted[i + 1] ?? Infinity) - wanted[i]!);
    let count = 1;
    while (count < kAtOnce && wanted[i + count] === wanted[i]! + count * every) ++count;
    const answer = await link.ask<MotionFrames>({
      kind: 'motion_frames',
      motion_frames: { session_id: session, first: wanted[i]!, count, every, with_shapes: true },
    });
    if (answer.revision !== revision || motion.newest !== revision) return; // newer ones follow
    motion.shape(revision, answer.frames);
    i += count;
  }
}
