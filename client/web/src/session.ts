// The session that the page shows: what is known of it, what is done to it.

import { aimed, editedAt } from './aim';
import { Drag } from './drag';
import { Frames } from './frames';
import { FileLink, Refusal, type Link, type Listener, type Measured, type PageInfo } from './link';
import type { Motion } from './motion';
import {
  edits,
  type EditBody,
  type EditTime,
  type FramesNews,
  type HandDescription,
  type Model,
  type MotionClock,
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

/** A pose that was shown, for looking back. */
export interface Past {
  revision: number;
  edit: string;
  solution: PoseSolution;
}

const kMostInFlight = 3; // of one drag, before the first of them is answered
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

  private readonly frames = new Frames(this);
  private readonly watchers: ((change: Change) => void)[] = [];
  private readonly notices: ((notice: Notice) => void)[] = [];
  private loaded = '';
  private mayEditAny = false;
  private lookAgain = false; // asked for while the last answer was on its way
  private countsAnew = false; // revisions, of a session that was opened again
  private lookTimer = 0;
  private looking = 0; // at which session
  private begun = 0; // steps that were there before the first edit
  /** Edits that were made as one: a drag. Undone as one, too. */
  private readonly groups: { from: number; to: number }[] = [];
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
    this.frames.forget();
    this.begun = 0;
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
    this.frames.rest();
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
    return this.motion === null || this.reach_s === null ? null : editedAt(this, this.time_s, texts);
  }

  /** Of a motion: the patch counts at that time. */
  isOn(patch: string, time_s: number): boolean {
    const edit = editedAt(this, time_s, [`enable ${patch}`, `disable ${patch}`]);
    if (edit !== null) return edit.startsWith('enable');
    return this.settings?.patches.find((one) => one.name === patch)?.enabled ?? true;
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
      await this.send(...aimed(this, body, this.time_s));
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
      const revision = await this.send(...aimed(this, body, time_s));
      if (isOfMotion) await this.frames.of(revision);
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
      void this.frames.fetch(state);
      this.frames.miss();
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
    if (session === this.id) this.frames.take(news);
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
    this.frames.outdate();
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
  timeEdits(revision: number): void {
    const now = performance.now();
    while (this.sent.length > 0 && this.sent[0]!.revision <= revision) {
      const one = this.sent.shift()!;
      // Those that a later edit overtook have no pose of their own.
      if (this.sent.length === 0 || this.sent[0]!.revision > revision) this.delays_ms.push(now - one.at_ms);
    }
  }

  // === Looking up

  private async resume(): Promise<void> {
    try {
      if (this.motion === null) this.solution = null; // the next one's numbers may begin anew
      const state = await this.link.follow(this.id);
      this.frames.outdate();
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
          ? this.frames.patchesOf(state.motion)
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

  /** Has the settings asked for, soon, and again while edits come. */
  look(): void {
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

  tell(change: Change): void {
    for (const watcher of this.watchers) watcher(change);
  }
}
