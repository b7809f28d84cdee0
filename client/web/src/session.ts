// The session that the page shows: what is known of it. What is done to it: editing.ts.

import { editedAt } from './aim';
import { Editing } from './editing';
import { Frames } from './frames';
import { FileLink, Refusal, type Link, type Listener, type Measured, type PageInfo } from './link';
import { Lookup } from './lookup';
import type { Motion } from './motion';
import type {
  FramesNews,
  HandDescription,
  Model,
  MotionClock,
  PatchInfo,
  PatchReport,
  Pose,
  PoseSolution,
  SessionSettings,
  SessionState,
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

const kLongestPast = 400;

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
  readonly past: Past[] = [];

  readonly editing = new Editing(this);
  readonly lookup = new Lookup(this);
  readonly frames = new Frames(this);

  private readonly watchers: ((change: Change) => void)[] = [];
  private readonly notices: ((notice: Notice) => void)[] = [];
  private mayEditAny = false;
  private countsAnew = false; // revisions, of a session that was opened again

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

  get isOfMotion(): boolean {
    return (this.state?.motion ?? '') !== '';
  }

  // === What is done

  /** Shows that session from now on; 0: none. */
  async show(session: number): Promise<void> {
    if (this.id !== 0 && this.id !== session) this.link.leave(this.id);
    this.id = session;
    this.state = this.solution = this.settings = this.motion = this.clock = this.measured = null;
    this.frames.forget();
    this.editing.restart();
    this.past.length = 0;
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

  /** All are switched off: the server looks for no pose, and the one before is shown. */
  get countsNone(): boolean {
    const { motion, settings, state } = this;
    return motion === null && settings !== null && settings.state.revision === state?.revision && !settings.patches.some((one) => one.enabled);
  }

  /** Of a motion: the patch counts at that time. */
  isOn(patch: string, time_s: number): boolean {
    const edit = editedAt(this, time_s, [`enable ${patch}`, `disable ${patch}`]);
    if (edit !== null) return edit.startsWith('enable');
    return this.settings?.patches.find((one) => one.name === patch)?.enabled ?? true;
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
    const isBack = isHeard && !this.isHeard;
    this.isHeard = isHeard;
    this.tell('link');
    // A page that was loaded while the server was away has not been told of its session yet.
    if (isBack && this.page !== 0 && this.id !== 0 && this.state === null) void this.resume();
  }

  onState(session: number, state: SessionState, isOurs: boolean, page: number): void {
    if (session !== this.id) return;
    const isNew = this.countsAnew || state.revision !== this.state?.revision;
    this.countsAnew = false;
    this.state = state;
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
    void this.lookup.models();
    if (this.isOfMotion) {
      void this.frames.fetch(state);
      this.frames.miss();
    }
    if (isNew) this.lookup.soon();
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
    this.editing.answered(solution.revision);
    const past: Past = { revision: solution.revision, edit: this.state?.last_edit ?? '', solution };
    if (again || this.past.at(-1)?.revision === solution.revision) this.past.pop();
    this.past.push(past);
    if (this.past.length > kLongestPast) this.past.shift();
    this.tell('pose');
    this.lookup.soon();
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
    if (this.motion === null) this.solution = null;
    this.frames.outdate();
    this.countsAnew = true;
    this.editing.moved();
    this.tell('link');
    this.notify('The server is back; the session goes on where it stood.');
    this.lookup.soon();
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

  private async resume(): Promise<void> {
    try {
      if (this.motion === null) this.solution = null; // the next one's numbers may begin anew
      this.editing.restart();
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

  tell(change: Change): void {
    for (const watcher of this.watchers) watcher(change);
  }
}
