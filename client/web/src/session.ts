// The session that the page shows: what is known of it, what is done to it.

import { Matrix4 } from 'three';
import { FileLink, Refusal, type Link, type Listener, type Measured, type PageInfo } from './link';
import { fetchMotion, fetchShapes, type Motion } from './motion';
import { matrixOf, poseOf } from './mesh';
import {
  edits,
  type DragBody,
  type EditBody,
  type EditTime,
  type FramesNews,
  type HandDescription,
  type Model,
  type MotionClock,
  type MotionDescription,
  type PatchInfo,
  type PatchReport,
  type Pose,
  type PoseSolution,
  type SessionSettings,
  type SessionState,
} from './wire';
import { saidBy } from './words';

export interface Models {
  hand: Model<HandDescription>;
  object: Model<{ name: string }>;
  contacts: Model<{ name: string; patches: PatchInfo[] }>;
}

export type Change = 'models' | 'motion' | 'frames' | 'reach' | 'grip' | 'clock' | 'pose' | 'state' | 'settings' | 'people' | 'link' | 'history' | 'measured' | 'none';

export interface Notice {
  text: string;
  kind: 'plain' | 'wrong';
}

/** What may hold about a time of a motion. */
const kTimed = new Set(['patch_root', 'patch_direction', 'patch_enabled', 'patch_weight', 'joint_limit', 'joint_lock', 'joint_soft', 'drag']);

/** A pose that was shown, for looking back. */
export interface Past {
  revision: number;
  edit: string;
  solution: PoseSolution;
}

const kFastest_ms = 25; // between two edits of one drag
const kMostInFlight = 3; // of one drag, before the first of them is answered
const kFrames_ms = 1500; // a drag's next edit of a motion waits so long for frames of the last
const kLookAgain_ms = 250; // settings, while edits follow each other
const kLongestPast = 400;
const kMove_ms = 5000; // until a session that its server lost has another number

export class Session implements Listener {
  id = 0;
  page = 0;
  isUp = false;
  isHeard = true;
  state: SessionState | null = null;
  solution: PoseSolution | null = null;
  settings: SessionSettings | null = null;
  reports: PatchReport[] = [];
  models: Models | null = null;
  /** A hand that followed a motion: it is looked at over time, and edited about times. */
  motion: Motion | null = null;
  /** Of the motion, the time that is shown. */
  time_s = 0;
  /** How far edits of a motion reach about that time, s; null: all of it. */
  reach_s: number | null = 0.3;
  /** That all who watch it share, and when it stood so. */
  clock: { clock: MotionClock; at_ms: number } | null = null;
  pages: PageInfo[] = [];
  /** Of the hand that follows the session, when it was heard last. */
  measured: { hand: Measured; at_ms: number } | null = null;
  /** Who made the last edit: "you", "guest 2", "another program". */
  editor = '';
  /** Drags and edits that are not answered yet. */
  underWay = 0;
  readonly past: Past[] = [];
  /** From an edit's sending to its pose, in ms. */
  readonly delays_ms: number[] = [];

  private readonly watchers: ((change: Change) => void)[] = [];
  private readonly notices: ((notice: Notice) => void)[] = [];
  private loaded = '';
  private fetched = ''; // which motion, solved how
  private description: { motion: string; model: Promise<Model<MotionDescription>> } | null = null;
  private mayEditAny = false;
  private lookAgain = false; // asked for while the last answer was on its way
  private countsAnew = false; // revisions, of a session that was opened again
  private lookTimer = 0;
  private looking = 0; // at which session
  private begun = 0; // steps that were there before the first edit
  /** Edits that were made as one: a drag. Undone as one, too. */
  private readonly groups: { from: number; to: number }[] = [];
  private readonly waitingForFrames: (() => void)[] = [];
  private isShaping = false;
  private frameTimer = 0; // for frames that were not told
  private readonly sent: { revision: number; at_ms: number }[] = [];

  constructor(readonly link: Link) {}

  watch(watcher: (change: Change) => void): void {
    this.watchers.push(watcher);
  }

  onNotice(told: (notice: Notice) => void): void {
    this.notices.push(told);
  }

  start(session: number): void {
    this.id = session;
    if (this.link instanceof FileLink) {
      this.id = this.link.data.state.session_id;
      this.past.push(...(this.link.data.past ?? []));
    }
    this.link.start(this);
  }

  get mayEdit(): boolean {
    return this.mayEditAny && (!this.isOfMotion || this.motion !== null);
  }

  /** Other sessions and models, whatever this one is. */
  get mayOpen(): boolean {
    return this.mayEditAny && this.link.isLive;
  }

  private get isOfMotion(): boolean {
    return (this.state?.motion ?? '') !== '';
  }

  // === What is done

  /** Shows that session from now on; 0: none. */
  async show(session: number): Promise<void> {
    this.id = session;
    this.state = this.solution = this.settings = this.motion = this.clock = this.measured = null;
    this.fetched = '';
    this.begun = 0;
    this.description = null;
    this.past.length = this.groups.length = 0;
    this.tell('none');
    if (session === 0) return;
    try {
      const state = await this.link.follow(session);
      this.onState(session, state, false, -1);
      // Who comes late is told the last pose; a session that has none is solved.
      if (state.phase === 'open' && this.mayEdit && this.solution === null) await this.solve();
    } catch (error) {
      this.id = 0;
      this.tell('none');
      this.failed(error);
    }
  }

  /** Sets the clock for all who watch; who only looks keeps a clock of his own. */
  setClock(action: 'play' | 'pause' | 'seek' | 'speed' | 'loop', value = 0): void {
    if (!this.mayEditAny || !this.link.isLive) return;
    this.link
      .ask({ kind: 'set_clock', clock: { session_id: this.id, action, value } })
      .catch((error: unknown) => this.failed(error));
  }

  /** Of a motion: the hand at that time. */
  showAt(time_s: number): void {
    this.time_s = time_s;
    if (this.motion === null) return;
    this.solution = this.motion.at(time_s, this.id);
    this.tell('pose');
  }

  /** Where the hand's links are, for joints that no solution tells of. */
  async linkPoses(X_WH: Pose, joint_positions: number[]): Promise<Pose[]> {
    const reply = await this.link.ask<{ X_WL: Pose[] }>({
      kind: 'link_poses',
      link_poses: { session_id: this.id, X_WH, joint_positions },
    });
    return reply.X_WL;
  }

  async solve(): Promise<void> {
    await this.link.ask({ kind: 'optimize', optimize: { session_id: this.id, options: null } });
  }

  /** Edits of a motion hold about the time that is shown, so many seconds; null: for all of it. */
  reach(reach_s: number | null): void {
    this.reach_s = reach_s;
    this.tell('reach');
  }

  /** Of a motion: the last that was edited so about the time that is shown; the texts are the server's. */
  editedHere(texts: string[]): string | null {
    if (this.motion === null || this.reach_s === null) return null;
    const covers = ({ time_s, falloff_s }: EditTime) => Math.abs(time_s - this.time_s) <= Math.max(falloff_s / 2, 1e-6);
    const found = (this.settings?.timed ?? []).filter((one) => texts.includes(one.text) && covers(one));
    return found.at(-1)?.text ?? null;
  }

  /** Takes an edit at a time back; refused where another edit came between. */
  async takeBack(index: number): Promise<void> {
    const base = this.settings?.state.revision ?? 0;
    if (!this.mayEdit || this.settings?.timed[index] === undefined) return;
    ++this.underWay;
    try {
      await this.link.edit(this.id, edits.takeBack(index), null, base);
    } catch (error) {
      this.failed(error);
    } finally {
      --this.underWay;
    }
    this.look();
  }

  /** One edit; refusals are told. */
  async edit(body: EditBody): Promise<boolean> {
    ++this.underWay;
    try {
      await this.send(...this.about(body, this.time_s));
      this.look(); // snapshots make no revision
      return true;
    } catch (error) {
      this.failed(error);
      return false;
    } finally {
      --this.underWay;
    }
  }

  /** The solve that a session begins with is no edit: without it the hand is far off. */
  get mayUndo(): boolean {
    return this.mayEdit && (this.state?.undo_count ?? 0) > this.begun;
  }

  async undo(): Promise<void> {
    if (!this.mayUndo) return;
    const last = this.groups.at(-1);
    const revision = this.state?.revision ?? 0;
    if (last !== undefined && last.to === revision) {
      this.groups.pop();
      await this.edit(edits.undo(last.to - last.from));
    } else {
      await this.edit(edits.undo(1));
    }
  }

  redo(): Promise<boolean> {
    return this.edit(edits.redo(1));
  }

  /** A stream of edits from one drag: the newest wins. Of a motion, all of them at one time. */
  drag(): Drag {
    ++this.underWay;
    this.tell('grip');
    const { time_s } = this;
    const isOfMotion = this.motion !== null;
    const send = async (body: EditBody) => {
      const revision = await this.send(...this.about(body, time_s));
      if (isOfMotion) await this.framesOf(revision);
      return revision;
    };
    return new Drag(
      send,
      isOfMotion ? 1 : kMostInFlight,
      (from, to) => {
        --this.underWay;
        if (to > from + 1) this.groups.push({ from, to });
        this.look();
      },
      (error) => this.failed(error),
    );
  }

  failed(error: unknown): void {
    const code = error instanceof Refusal ? error.code : '';
    if (code === 'no_link' || code === 'no_server') return; // the banner says so
    this.notify(error instanceof Error ? error.message : String(error), 'wrong');
  }

  notify(text: string, kind: Notice['kind'] = 'plain'): void {
    for (const told of this.notices) told({ text, kind });
  }

  nameOf(page: number): string {
    if (page === this.page) return 'you';
    return page > 0 ? `guest ${page}` : 'another program';
  }

  // === What is told

  onWelcome(page: number, mayEdit: boolean): void {
    this.page = page;
    this.mayEditAny = mayEdit;
    if (this.id !== 0) void this.resume();
    else this.tell('none');
  }

  onLink(isUp: boolean): void {
    this.isUp = isUp;
    this.tell('link');
  }

  onServer(isHeard: boolean): void {
    this.isHeard = isHeard;
    this.tell('link');
  }

  onState(session: number, state: SessionState, isOurs: boolean, page: number): void {
    if (session !== this.id) return;
    const isNew = this.countsAnew || state.revision !== this.state?.revision;
    this.countsAnew = false;
    this.state = state;
    if (state.revision === 0) this.begun = state.undo_count;
    if (state.last_edit !== '' && page >= 0) {
      this.editor = this.nameOf(isOurs ? page || this.page : 0);
      if (isNew && this.editor !== 'you') this.notify(saidBy(this.editor, state.last_edit));
    }
    this.tell('state');
    if (state.phase === 'closed') {
      this.notify('The session has been closed.', 'wrong');
      void this.show(0);
      return;
    }
    if (state.phase === 'failed') this.notify(state.message, 'wrong');
    void this.load();
    if (this.isOfMotion) {
      void this.fetch(state);
      this.missFrames();
    }
    if (isNew) this.look();
  }

  onPose(session: number, solution: PoseSolution): void {
    // Of a motion its frames are shown, not the grasp that stands for it.
    if (session !== this.id || this.motion !== null) return;
    // A pose that an older edit asked for does not come back behind a newer one.
    if (this.solution !== null && solution.sequence_number < this.solution.sequence_number) {
      if (solution.revision < this.solution.revision) return;
    }
    const again = this.solution?.sequence_number === solution.sequence_number - 1 &&
      this.solution.revision === solution.revision;
    this.solution = solution;
    this.timeEdits(solution.revision);
    const past: Past = { revision: solution.revision, edit: this.state?.last_edit ?? '', solution };
    if (again || this.past.at(-1)?.revision === solution.revision) this.past.pop();
    this.past.push(past);
    if (this.past.length > kLongestPast) this.past.shift();
    this.tell('pose');
    this.look();
  }

  onFrames(session: number, news: FramesNews): void {
    const motion = this.motion;
    if (session !== this.id || motion === null || news.revision < motion.revision) return;
    motion.preview(news.revision, news.frames ?? []);
    if (news.is_last) {
      const isWhole = news.frames !== null && news.since === motion.revision;
      if (isWhole) {
        motion.complete(news.revision);
        void this.shape(motion);
      } else {
        void this.fetchAgain();
      }
      this.look();
    }
    this.missFrames();
    this.timeEdits(news.revision);
    this.solution = motion.at(this.time_s, this.id);
    this.tell('frames');
    this.tell('pose');
    for (const wait of this.waitingForFrames.splice(0)) wait();
  }

  onClock(session: number, clock: MotionClock, age_s: number): void {
    if (session !== this.id) return;
    this.clock = { clock, at_ms: performance.now() - 1e3 * age_s };
    this.tell('clock');
  }

  onPages(pages: PageInfo[]): void {
    this.pages = pages;
    this.tell('people');
  }

  onMoved(from: number, to: number): void {
    if (from !== this.id) return;
    this.id = to;
    this.begun = 0;
    if (this.motion === null) this.solution = null;
    this.fetched = '';
    this.countsAnew = true;
    this.groups.length = this.sent.length = 0;
    this.tell('link');
    this.notify('The server is back; the session goes on where it stood.');
    this.look();
  }

  onLost(session: number, message: string): void {
    if (session !== this.id) return;
    this.notify(message, 'wrong');
  }

  onMeasured(session: number, hand: Measured): void {
    if (session !== this.id) return;
    this.measured = { hand, at_ms: performance.now() };
    this.tell('measured');
  }

  /** What was shown now answers the edits up to that revision. */
  private timeEdits(revision: number): void {
    const now = performance.now();
    while (this.sent.length > 0 && this.sent[0]!.revision <= revision) {
      const one = this.sent.shift()!;
      // Those that a later edit overtook have no pose of their own.
      if (this.sent.length === 0 || this.sent[0]!.revision > revision) this.delays_ms.push(now - one.at_ms);
    }
  }

  // === Edits of a motion

  /** An edit, and about which time of the motion it holds. */
  private about(body: EditBody, time_s: number): [EditBody, EditTime | null] {
    if (this.motion === null || !kTimed.has(body.kind)) return [body, null];
    if (this.reach_s !== null) {
      const drag = body['drag'] as DragBody | undefined;
      // A place is moved; links are not turned at a time.
      const there = drag === undefined ? body : { ...body, drag: { ...drag, target_q_wxyz: [] } };
      return [there, { time_s, falloff_s: this.reach_s }];
    }
    if (body.kind === 'drag') return [this.inGrasp(body, time_s), null];
    return [body, null];
  }

  /** A drag for all of the motion, told where the session has the object, not where the motion has it then. */
  private inGrasp(body: EditBody, time_s: number): EditBody {
    const drag = body['drag'] as DragBody;
    const X_WO = this.settings?.X_WO;
    if (X_WO === undefined) return body;
    const X = matrixOf(X_WO).multiply(matrixOf(this.motion!.at(time_s, this.id).X_WO).invert());
    const [w, x, y, z] = drag.target_q_wxyz;
    const isTurned = w !== undefined;
    const target = new Matrix4().multiplyMatrices(X, matrixOf({
      p_m: drag.target_W_m as [number, number, number],
      q_wxyz: isTurned ? [w, x!, y!, z!] : [1, 0, 0, 0],
    }));
    const { p_m, q_wxyz } = poseOf(target);
    return { ...body, drag: { ...drag, target_W_m: p_m, target_q_wxyz: isTurned ? q_wxyz : [] } };
  }

  /** Waits until frames of that revision, or a later one, are shown; not for ever. */
  private async framesOf(revision: number): Promise<void> {
    const begun = performance.now();
    while ((this.motion?.newest ?? revision) < revision) {
      const rest = kFrames_ms - (performance.now() - begun);
      if (rest <= 0) return;
      await new Promise<void>((resolve) => {
        const timer = setTimeout(resolve, rest);
        this.waitingForFrames.push(() => {
          clearTimeout(timer);
          resolve();
        });
      });
    }
  }

  /** The outlines of what was solved anew, one motion at a time. */
  private async shape(motion: Motion): Promise<void> {
    if (this.isShaping) return;
    this.isShaping = true;
    try {
      while (motion === this.motion && motion.unshaped.size > 0) {
        const { revision } = motion;
        await fetchShapes(this.link, this.id, motion);
        if (motion === this.motion && motion.newest === motion.revision) {
          this.solution = motion.at(this.time_s, this.id);
          this.tell('frames');
          this.tell('pose');
        }
        if (motion.newest !== revision) await new Promise((resolve) => setTimeout(resolve, kLookAgain_ms));
      }
    } catch (error) {
      this.failed(error);
    } finally {
      this.isShaping = false;
    }
  }

  private fetchAgain(): Promise<void> {
    this.fetched = '';
    return this.state === null ? Promise.resolve() : this.fetch(this.state);
  }

  // === Looking up

  private async resume(): Promise<void> {
    try {
      if (this.motion === null) this.solution = null; // the next one's numbers may begin anew
      const state = await this.link.follow(this.id);
      this.fetched = '';
      this.onState(this.id, state, false, -1);
      if (state.phase === 'open' && this.mayEdit && !this.isOfMotion) await this.solve();
    } catch (error) {
      if (error instanceof Refusal && (error.code === 'no_link' || error.code === 'no_server')) return;
      this.id = 0;
      this.failed(error);
      this.tell('none');
    }
  }

  /** The session's models, when they are others than before. */
  private async load(): Promise<void> {
    const state = this.state;
    if (state === null) return;
    const key = `${state.hand}\n${state.object}\n${state.contacts}\n${state.motion}`;
    if (key === this.loaded) return;
    this.loaded = key;
    try {
      const [hand, object, contacts] = await Promise.all([
        this.link.describe<HandDescription>('hand', state.hand),
        this.link.describe<{ name: string }>('object', state.object),
        this.isOfMotion
          ? this.patchesOf(state.motion)
          : this.link.describe<{ name: string; patches: PatchInfo[] }>('contacts', state.contacts),
      ]);
      if (this.loaded !== key) return;
      this.models = { hand, object, contacts };
      this.tell('models');
      this.look();
    } catch (error) {
      this.loaded = '';
      this.failed(error);
    }
  }

  /** A motion has patches, too; their outlines are its frames'. */
  private async patchesOf(motion: string): Promise<Models['contacts']> {
    const model = await this.described(motion);
    const { name, patches } = model.description;
    return { ...model, description: { name, patches: patches.map((patch) => ({ name: patch, outline_O_m: [] })) } };
  }

  private described(motion: string): Promise<Model<MotionDescription>> {
    if (this.description?.motion !== motion) {
      const model = this.link.describe<MotionDescription>('motion', motion);
      this.description = { motion, model };
      model.catch(() => (this.description = null));
    }
    return this.description.model;
  }

  /** Frames that nobody told of, or that went by while others were asked for, are asked for once it is quiet. */
  private missFrames(): void {
    clearTimeout(this.frameTimer);
    this.frameTimer = window.setTimeout(() => {
      const { state, motion } = this;
      if (state?.phase !== 'ready' || motion === null) return;
      if (motion.revision < state.revision) void this.fetchAgain();
      else if (motion.unshaped.size > 0) void this.shape(motion);
    }, kFrames_ms);
  }

  /** The frames, once; later ones are told. */
  private async fetch(state: SessionState): Promise<void> {
    const key = `${this.id} ${state.motion}`;
    if (key === this.fetched || state.phase === 'transferring' || state.phase === 'optimizing') return;
    this.fetched = key;
    try {
      const { description } = await this.described(state.motion);
      const motion = await fetchMotion(this.link, this.id, description, this.mayEditAny, (share) => {
        this.notify(`frames: ${Math.round(100 * share)} %`);
      });
      if (this.fetched !== key) return;
      if (motion.frames.length === 0) throw new Error('the motion has no frames yet');
      this.motion = motion;
      this.missFrames();
      this.tell('motion');
      this.look();
    } catch (error) {
      if (this.fetched === key) this.fetched = '';
      this.failed(error);
    }
  }

  /** Has the settings asked for, soon, and again while edits come. */
  private look(): void {
    if (this.isOfMotion && this.motion === null) return;
    this.lookAgain = this.looking === this.id;
    if (this.lookTimer !== 0 || this.lookAgain) return;
    this.lookTimer = window.setTimeout(() => void this.lookNow(), this.settings === null ? 0 : kLookAgain_ms);
  }

  private async lookNow(): Promise<void> {
    this.lookTimer = 0;
    this.lookAgain = false;
    const key = this.id;
    this.looking = key;
    const seen = this.solution?.sequence_number;
    try {
      const session = { session_id: key };
      const [settings, transfer] = await Promise.all([
        this.link.ask<SessionSettings>({ kind: 'session_settings', session }),
        // Of a motion its frames tell more.
        this.isOfMotion ? { patches: [] } : this.link.ask<{ patches: PatchReport[] }>({ kind: 'transfer', session }),
      ]);
      // A session that has moved meanwhile is looked at under its new number.
      if (key !== this.id) return;
      this.settings = settings;
      this.reports = transfer.patches;
      this.tell('settings');
    } catch (error) {
      if (key !== this.id) return;
      this.failed(error);
    } finally {
      if (this.looking === key) this.looking = 0;
    }
    if (this.motion !== null) {
      const isOld = this.settings !== null && this.settings.state.revision < (this.state?.revision ?? 0);
      if (this.lookAgain || isOld) this.look();
      return;
    }
    if (this.lookAgain || seen !== this.solution?.sequence_number) this.look();
  }

  private async send(body: EditBody, when: EditTime | null): Promise<number> {
    const at_ms = performance.now();
    const id = this.id;
    const reply = await this.link.edit(id, body, when).catch(async (error: unknown) => {
      // A server that has just come back opens the session anew, under another number.
      const isGone = error instanceof Refusal && error.code === 'not_found' && error.message.startsWith(`session ${id} `);
      for (let waited = 0; isGone && this.id === id && waited < kMove_ms; waited += 100) await new Promise((resolve) => setTimeout(resolve, 100));
      if (!isGone || this.id === id) throw error;
      return this.link.edit(this.id, body, when);
    });
    if ((this.solution?.revision ?? -1) >= reply.revision) {
      this.delays_ms.push(performance.now() - at_ms);
    } else {
      this.sent.push({ revision: reply.revision, at_ms });
    }
    if (reply.message !== '') this.notify(reply.message);
    return reply.revision;
  }

  private tell(change: Change): void {
    for (const watcher of this.watchers) watcher(change);
  }
}

export class Drag {
  private next: EditBody | (() => EditBody) | null = null;
  private inFlight = 0;
  private sent_ms = -Infinity;
  private timer = 0;
  private done = false;
  private first = Infinity;
  private last = -1;

  constructor(
    private readonly send: (body: EditBody) => Promise<number>,
    private readonly most: number, // edits that are not answered yet
    private readonly finished: (from: number, to: number) => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  /** A function is called when its edit is sent: for what adds up. */
  move(body: EditBody | (() => EditBody)): void {
    this.next = body;
    this.pump();
  }

  /** What was moved last still counts. */
  end(): void {
    this.done = true;
    this.pump();
  }

  /** Sends the newest, unless too many are on their way or the last one has only just been sent. */
  private pump(): void {
    if (this.next === null) {
      if (this.done && this.inFlight === 0) this.close();
      return;
    }
    if (this.inFlight >= this.most || this.timer !== 0) return;
    const rest = kFastest_ms - (performance.now() - this.sent_ms);
    if (rest > 0) {
      this.timer = window.setTimeout(() => {
        this.timer = 0;
        this.pump();
      }, rest);
      return;
    }
    const body = typeof this.next === 'function' ? this.next() : this.next;
    this.next = null;
    this.sent_ms = performance.now();
    void this.run(body);
  }

  private async run(body: EditBody): Promise<void> {
    ++this.inFlight;
    try {
      const revision = await this.send(body);
      this.first = Math.min(this.first, revision - 1);
      this.last = Math.max(this.last, revision);
    } catch (error) {
      this.failed(error);
      this.next = null;
    }
    --this.inFlight;
    this.pump();
  }

  private close(): void {
    this.done = false;
    this.finished(this.last < 0 ? 0 : this.first, Math.max(this.last, 0));
  }
}
