// Messages as idl/json writes them: the fields of them that the page uses (idl/*.idl says what they mean).

export interface Pose {
  p_m: [number, number, number];
  q_wxyz: [number, number, number, number];
}

export interface SurfacePoint {
  face: number;
  barycentric: [number, number, number];
}

export interface SessionState {
  session_id: number;
  revision: number;
  phase: 'open' | 'transferring' | 'optimizing' | 'ready' | 'failed' | 'closed';
  hand: string;
  object: string;
  contacts: string;
  motion: string; // empty: it holds none
  joint_names: string[];
  message: string;
  undo_count: number;
  redo_count: number;
  last_edit: string;
}

export interface LimitSensitivity {
  limit: { joint: string; side: 'lower' | 'upper' };
  gain_mm: number;
  given: number;
  kind: 'revolute' | 'prismatic';
}

export interface PatchFit {
  name: string;
  point_count: number;
  mean_mm: number;
  max_mm: number;
  normal_deg: number;
  hand_W_m: number[];
  object_W_m: number[];
  diagnosis: Diagnosis;
}

export interface Diagnosis {
  verdict: Verdict;
  text: string;
  miss_m?: number; // beyond what counts as reached; of a motion's frames neither is looked for
  alone_mm?: number; // what it would come to if nothing else were asked for
}

export type Verdict = 'none' | 'reached' | 'at_limit' | 'out_of_reach' | 'normals_in_conflict' | 'no_clearance';

export interface MinimumInfo {
  solver: string;
  hits: number;
  terms: { objective: number };
  X_WH: Pose;
  joint_positions: number[];
}

export interface PoseSolution {
  session_id: number;
  revision: number;
  sequence_number: number;
  outcome: string;
  solver: string;
  X_WH: Pose;
  X_WO: Pose;
  joint_positions: number[];
  X_WL: Pose[];
  terms: { distance_m2: number; normal: number; prior: number; objective: number };
  patches: PatchFit[];
  joints_at_limit: { joint: string; side: 'lower' | 'upper' }[];
  held: { link: string; target_W_m: [number, number, number] }[];
  is_diagnosed: boolean;
  verdict: string;
  sensitivities: LimitSensitivity[];
  penetration: {
    max_depth_m: number;
    volume_m3: number;
    links: { link: string; depth_m: number }[];
    self_depth_m: number;
  } | null;
  minima: MinimumInfo[];
  chosen_minimum: number;
  times: { stage: string; duration_ms: number }[];
}

export interface PatchState {
  name: string;
  enabled: boolean;
  weight: number;
  placed: boolean;
  reason: string;
  root_O: SurfacePoint;
  direction_O: [number, number, number];
  root_S: SurfacePoint;
  direction_S: [number, number, number];
}

/** A number, or "inf", "-inf", "nan". */
export type Extended = number | string;

export interface JointSetting {
  name: string;
  kind: 'revolute' | 'prismatic';
  value: number;
  lower: Extended;
  upper: Extended;
  model_lower: Extended;
  model_upper: Extended;
  locked: boolean;
  soft: boolean; // held at `prior`
  prior: number;
}

export interface SessionSettings {
  state: SessionState;
  X_WO: Pose;
  weights: { distance: number; normal: number; prior: number; posture: number };
  patches: PatchState[];
  joints: JointSetting[];
  snapshots: string[];
  held: { link: string }[];
  notes: string[];
  timed: TimedState[];
}

/** An edit at a time of a motion, as it holds. */
export interface TimedState extends EditTime {
  text: string;
}

/** Fully at `time_s`, fading to nothing `falloff_s` away from it. */
export interface EditTime {
  time_s: number;
  falloff_s: number;
}

export interface PatchReport {
  name: string;
  placed: boolean;
  point_count: number;
  boundary_count: number;
  lost: { index: number; ring: number; reason: string }[];
}

export interface HandDescription {
  name: string;
  joints: { name: string; kind: string; lower: Extended; upper: Extended }[];
  links: { name: string }[];
  sites: { name: string; link: string; p_L_m: [number, number, number] }[];
  X_SL: Pose[];
  urdf: string;
  notes: string[];
}

export interface PatchInfo {
  name: string;
  outline_O_m: number[];
}

export interface MotionDescription {
  name: string;
  duration_s: number;
  frame_count: number;
  patches: string[];
}

export interface FramePatch {
  patch: number; // of MotionDescription.patches
  presence: number;
  mean_mm: number;
  normal_deg: number;
  reached: boolean;
  outline_O_m: number[];
  hand_W_m: number[]; // of as many points, in the same order
}

export interface MotionFrame {
  index: number;
  time_s: number;
  X_WH: Pose;
  X_WO: Pose;
  joint_positions: number[];
  patches: FramePatch[]; // that are there
  max_depth_m: number;
  self_depth_m: number;
  joints_at_limit: { joint: string; side: 'lower' | 'upper' }[];
  X_WL: Pose[];
}

/** One clock that all who watch a motion share. */
export interface MotionClock {
  playing: boolean;
  looping: boolean;
  speed: number;
  time_s: number;
  duration_s: number;
}

export interface MotionFrames {
  revision: number;
  frame_count: number;
  frames: MotionFrame[];
}

/** Of a motion that is solved anew: all frames of `revision` that came so far, without outlines. */
export interface FramesNews {
  since: number | null; // the revision that they differ from; null: not known
  revision: number;
  is_last: boolean;
  every: number; // of many frames every second, fourth, ... by its index
  frames: MotionFrame[];
}

export interface ModelSummary {
  kind: 'hand' | 'object' | 'contacts' | 'motion';
  name: string;
  text: string;
}

export interface Mesh {
  vertices: Float32Array;
  triangles: Uint32Array;
}

/** A model's description and its meshes (client/gateway/model_frame.h). */
export interface Model<Description> {
  description: Description;
  frame: ArrayBuffer;
  mesh(name: string): Mesh;
  floats(name: string): Float32Array;
  ints(name: string): Int32Array;
}

export function readModel<Description>(frame: ArrayBuffer): Model<Description> & { request: number } {
  const head = new DataView(frame);
  const request = head.getUint32(0, true);
  const length = head.getUint32(4, true);
  const text = new TextDecoder().decode(new Uint8Array(frame, 8, length));
  const { description, arrays } = JSON.parse(text) as {
    description: Record<string, unknown>;
    arrays: { name: string; at: number; count: number }[];
  };
  const begin = Math.ceil((8 + length) / 4) * 4;
  const places = new Map(arrays.map((array) => [array.name, array]));
  const at = (name: string) => places.get(name) ?? { at: 0, count: 0 };
  // The union's member is named after its kind.
  const kind = description['kind'] as string;
  return {
    request,
    frame,
    description: description[kind] as Description,
    mesh: (name) => ({
      vertices: new Float32Array(frame, begin + at(`${name}/vertices`).at, at(`${name}/vertices`).count),
      triangles: new Uint32Array(frame, begin + at(`${name}/triangles`).at, at(`${name}/triangles`).count),
    }),
    floats: (name) => new Float32Array(frame, begin + at(name).at, at(name).count),
    ints: (name) => new Int32Array(frame, begin + at(name).at, at(name).count),
  };
}

export function finite(value: Extended, otherwise: number): number {
  return typeof value === 'number' ? value : otherwise;
}

// === Edits (idl/edits.idl)

export type Side = 'object' | 'hand';
export type EditBody = { kind: string } & Record<string, unknown>;

export interface DragBody {
  link: string;
  p_L_m: number[];
  target_W_m: number[];
  target_q_wxyz: number[];
  weight: number;
}

export const edits = {
  root: (patch: string, side: Side, root: SurfacePoint): EditBody => ({
    kind: 'patch_root',
    patch_root: { patch, side, root },
  }),
  turn: (patch: string, side: Side, angle_rad: number): EditBody => ({
    kind: 'patch_direction',
    patch_direction: { patch, side, angle_rad },
  }),
  enable: (patch: string, enabled: boolean): EditBody => ({
    kind: 'patch_enabled',
    patch_enabled: { patch, enabled },
  }),
  patchWeight: (patch: string, weight: number): EditBody => ({
    kind: 'patch_weight',
    patch_weight: { patch, weight },
  }),
  limit: (joint: string, lower: Extended, upper: Extended): EditBody => ({
    kind: 'joint_limit',
    joint_limit: { joint, lower, upper },
  }),
  lock: (joint: string, locked: boolean): EditBody => ({ kind: 'joint_lock', joint_lock: { joint, locked } }),
  hold: (joint: string, value: number, weight: number): EditBody => ({
    kind: 'joint_soft',
    joint_soft: { joint, value, weight },
  }),
  drag: (link: string, p_L_m: number[], target_W_m: number[], weight: number, target_q_wxyz: number[] = []): EditBody => ({
    kind: 'drag',
    drag: { link, p_L_m, target_W_m, target_q_wxyz, weight },
  }),
  takeBack: (index: number): EditBody => ({ kind: 'take_back', take_back: { index } }),
  release: (link: string): EditBody => ({ kind: 'release', release: { link } }),
  place: (X_WO: Pose): EditBody => ({ kind: 'object_pose', X_WO }),
  weights: (weights: SessionSettings['weights']): EditBody => ({ kind: 'weights', weights }),
  choose: (rank: number): EditBody => ({ kind: 'choice', choice: { rank } }),
  undo: (count: number): EditBody => ({ kind: 'undo', steps: { count } }),
  redo: (count: number): EditBody => ({ kind: 'redo', steps: { count } }),
  snapshot: (name: string): EditBody => ({ kind: 'snapshot', snapshot: { name } }),
  restore: (name: string): EditBody => ({ kind: 'restore', snapshot: { name } }),
};
