// The frames of a session's motion: asked for once, told as they are solved anew, their outlines and those between them afterwards.

import { fetchFine, fetchMotion, fetchShapes, type Motion } from './motion';
import type { Session } from './session';
import type { FramesNews, Model, MotionDescription, PatchInfo, SessionState } from './wire';

const kFrames_ms = 1500; // a drag's next edit waits so long for frames of the last
const kAgain_ms = 250; // between two looks for outlines, while edits follow each other
const kRest_ms = 200; // that a time is shown before more frames about it are asked for

export class Frames {
  private fetched = ''; // of which session and motion
  private description: { motion: string; model: Promise<Model<MotionDescription>> } | null = null;
  private readonly waiting: (() => void)[] = [];
  private isShaping = false;
  private missTimer = 0; // for frames that were not told
  private fineTimer = 0;

  constructor(private readonly session: Session) {}

  /** Another session, or none. */
  forget(): void {
    this.fetched = '';
    this.description = null;
  }

  /** Those that are there are of a server, or a connection, that went. */
  outdate(): void {
    this.fetched = '';
  }

  /** What was told of the session's motion, solved anew. */
  take(news: FramesNews): void {
    const { session } = this;
    const { motion } = session;
    if (motion === null || news.revision < motion.revision) return;
    motion.preview(news.revision, news.frames);
    if (news.is_last) {
      if (news.since === motion.revision && news.every <= motion.every) {
        motion.complete(news.revision, news.every);
        void this.shape(motion);
        this.rest();
      } else {
        void this.fetchAgain();
      }
      session.lookup.soon();
    }
    this.miss();
    session.editing.answered(news.revision);
    this.show(motion);
    for (const wait of this.waiting.splice(0)) wait();
  }

  /** Waits until frames of that revision, or a later one, are shown; not for ever. */
  async of(revision: number): Promise<void> {
    const begun = performance.now();
    while ((this.session.motion?.newest ?? revision) < revision) {
      const rest = kFrames_ms - (performance.now() - begun);
      if (rest <= 0) return;
      await new Promise<void>((resolve) => {
        const timer = setTimeout(resolve, rest);
        this.waiting.push(() => {
          clearTimeout(timer);
          resolve();
        });
      });
    }
  }

  /** The frames, once; later ones are told. */
  async fetch(state: SessionState): Promise<void> {
    const { session } = this;
    const key = `${session.id} ${state.motion}`;
    if (key === this.fetched || state.phase === 'transferring' || state.phase === 'optimizing') return;
    this.fetched = key;
    try {
      const { description } = await this.described(state.motion);
      const motion = await fetchMotion(session.link, session.id, description, session.mayOpen, (share) => {
        session.notify(`frames: ${Math.round(100 * share)} %`);
      });
      if (this.fetched !== key) return;
      if (motion.frames.length === 0) throw new Error('the motion has no frames yet');
      session.motion = motion;
      this.miss();
      session.tell('motion');
      session.lookup.soon();
      this.rest();
    } catch (error) {
      if (this.fetched === key) this.fetched = '';
      session.failed(error);
    }
  }

  /** Frames that nobody told of, or that went by while others were asked for, are asked for once it is quiet. */
  miss(): void {
    clearTimeout(this.missTimer);
    this.missTimer = window.setTimeout(() => {
      const { state, motion } = this.session;
      if (state?.phase !== 'ready' || motion === null) return;
      if (motion.revision < state.revision) void this.fetchAgain();
      else if (motion.unshaped.size > 0) void this.shape(motion);
    }, kFrames_ms);
  }

  /** Of a long motion, all frames about the time that is shown, once it is for a moment. */
  rest(): void {
    clearTimeout(this.fineTimer);
    if ((this.session.motion?.every ?? 1) === 1) return;
    this.fineTimer = window.setTimeout(() => void this.refine(), kRest_ms);
  }

  /** A motion has patches, too; their outlines are its frames'. */
  async patchesOf(motion: string): Promise<Model<{ name: string; patches: PatchInfo[] }>> {
    const model = await this.described(motion);
    const { name, patches } = model.description;
    return { ...model, description: { name, patches: patches.map((patch) => ({ name: patch, outline_O_m: [] })) } };
  }

  private described(motion: string): Promise<Model<MotionDescription>> {
    if (this.description?.motion !== motion) {
      const model = this.session.link.describe<MotionDescription>('motion', motion);
      this.description = { motion, model };
      model.catch(() => (this.description = null));
    }
    return this.description.model;
  }

  private fetchAgain(): Promise<void> {
    this.fetched = '';
    const { state } = this.session;
    return state === null ? Promise.resolve() : this.fetch(state);
  }

  private async refine(): Promise<void> {
    const { session } = this;
    const { motion } = session;
    if (motion === null || !session.link.isLive || motion.newest !== motion.revision) return;
    try {
      const isFiner = await fetchFine(session.link, session.id, motion, session.time_s);
      if (isFiner && motion === session.motion) this.show(motion);
    } catch (error) {
      session.failed(error);
    }
  }

  /** The outlines of what was solved anew, one motion at a time. */
  private async shape(motion: Motion): Promise<void> {
    if (this.isShaping) return;
    this.isShaping = true;
    const { session } = this;
    try {
      while (motion === session.motion && motion.unshaped.size > 0) {
        const { revision } = motion;
        await fetchShapes(session.link, session.id, motion);
        if (motion === session.motion && motion.newest === motion.revision) this.show(motion);
        if (motion.newest !== revision) await new Promise((resolve) => setTimeout(resolve, kAgain_ms));
      }
    } catch (error) {
      session.failed(error);
    } finally {
      this.isShaping = false;
    }
  }

  private show(motion: Motion): void {
    const { session } = this;
    session.solution = motion.at(session.time_s, session.id);
    session.tell('frames');
    session.tell('pose');
  }
}
