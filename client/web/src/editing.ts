// What is done to a session: edits, drags, their undo; and how long each takes to its pose.

import { aimed } from './aim';
import { Drag } from './drag';
import { Refusal } from './link';
import type { Session } from './session';
import { Steps } from './steps';
import { edits, type EditBody, type EditTime } from './wire';

const kMostInFlight = 3; // of one drag, before the first of them is answered
const kMove_ms = 5000; // until a session that its server lost has another number
const kLook_ms = 10; // between two looks whether what was sent has come about
/** What leaves the steps that can be undone as they are, or goes along them. */
const kNoStep = new Set(['undo', 'redo', 'snapshot']);

export class Editing {
  /** Drags and edits that are not answered yet. */
  underWay = 0;
  /** From an edit's sending to its pose, in ms. */
  readonly delays_ms: number[] = [];

  private readonly steps = new Steps();
  /** Undo and redo one after the other, each from where the one before led. */
  private turn: Promise<unknown> = Promise.resolve();
  private newest = 0; // revision that an edit of this page came to
  private unanswered = 0;
  private readonly sent: { revision: number; at_ms: number }[] = [];

  constructor(private readonly session: Session) {}

  /** Another session, or none; or the same one, whose revisions may count anew: nothing that was on its way is answered any more. */
  restart(): void {
    this.newest = 0;
    this.sent.length = 0;
  }

  /** The same session under another number. */
  moved(): void {
    this.restart();
    this.steps.of(this.session.id, true);
  }

  /** One edit; refusals are told. */
  async edit(body: EditBody): Promise<boolean> {
    const { session } = this;
    if (!kNoStep.has(body.kind)) this.cut();
    ++this.underWay;
    try {
      await this.send(...aimed(session, body, session.time_s));
      session.lookup.soon(); // snapshots make no revision
      return true;
    } catch (error) {
      session.failed(error);
      return false;
    } finally {
      --this.underWay;
    }
  }

  /** Takes an edit at a time back; refused where another edit came between. */
  async takeBack(index: number): Promise<void> {
    const { session } = this;
    const base = session.settings?.state.revision ?? 0;
    if (!session.mayEdit || session.settings?.timed[index] === undefined) return;
    ++this.underWay;
    try {
      await session.link.edit(session.id, edits.takeBack(index), null, base);
    } catch (error) {
      session.failed(error);
    } finally {
      --this.underWay;
    }
    session.lookup.soon();
  }

  get mayUndo(): boolean {
    return this.session.mayEdit && (this.session.state?.undo_count ?? 0) > 0;
  }

  undo(): void {
    this.go('undo');
  }

  redo(): void {
    this.go('redo');
  }

  private go(way: 'undo' | 'redo'): void {
    this.inTurn((undone, redone) => {
      this.steps.clip(undone + redone);
      if (!this.session.mayEdit || (way === 'undo' ? undone : redone) === 0) return; // pressed once more than there are steps
      return this.edit(way === 'undo' ? edits.undo(this.steps.back(undone)) : edits.redo(this.steps.forth(undone)));
    });
  }

  /** Once the session's state tells of all that was sent: with how many steps can be undone and done again then. */
  private inTurn(act: (undone: number, redone: number, revision: number) => unknown): void {
    const { session } = this;
    const { id } = session;
    this.turn = this.turn.then(async () => {
      const isBehind = () => this.unanswered > 0 || (session.state?.revision ?? 0) < this.newest;
      for (let waited = 0; isBehind() && waited < kMove_ms; waited += kLook_ms) await new Promise((resolve) => setTimeout(resolve, kLook_ms));
      const { state } = session;
      if (state === null || session.id !== id) return;
      this.steps.of(id);
      await act(state.undo_count, state.redo_count, state.revision);
    });
  }

  private cut(): void {
    this.steps.of(this.session.id);
    this.steps.cut(this.session.state?.undo_count ?? 0);
  }

  /** A stream of edits from one drag: the newest wins. Of a motion, all of them at one time. */
  drag(): Drag {
    const { session } = this;
    this.cut();
    ++this.underWay;
    session.tell('grip');
    const { time_s } = session;
    const isOfMotion = session.motion !== null;
    const send = async (body: EditBody) => {
      const revision = await this.send(...aimed(session, body, time_s));
      if (isOfMotion) await session.frames.of(revision);
      return revision;
    };
    return new Drag(
      send,
      isOfMotion ? 1 : kMostInFlight,
      (from, to) => {
        --this.underWay;
        if (to > from + 1) this.inTurn((undone, _, revision) => this.steps.join(undone - (revision - to), to - from));
        session.lookup.soon();
      },
      (error) => session.failed(error),
    );
  }

  /** What was shown now answers the edits up to that revision. */
  answered(revision: number): void {
    const now = performance.now();
    while (this.sent.length > 0 && this.sent[0]!.revision <= revision) {
      const one = this.sent.shift()!;
      // Those that a later edit overtook have no pose of their own.
      if (this.sent.length === 0 || this.sent[0]!.revision > revision) this.delays_ms.push(now - one.at_ms);
    }
  }

  private async send(body: EditBody, when: EditTime | null): Promise<number> {
    const { session } = this;
    const at_ms = performance.now();
    const { id } = session;
    ++this.unanswered;
    const reply = await session.link
      .edit(id, body, when)
      .catch(async (error: unknown) => {
        // A server that has just come back opens the session anew, under another number.
        const isGone = error instanceof Refusal && error.code === 'not_found' && error.message.startsWith(`session ${id} `);
        for (let waited = 0; isGone && session.id === id && waited < kMove_ms; waited += 100) await new Promise((resolve) => setTimeout(resolve, 100));
        if (!isGone || session.id === id) throw error;
        return session.link.edit(session.id, body, when);
      })
      .finally(() => --this.unanswered);
    this.newest = Math.max(this.newest, reply.revision);
    if ((session.solution?.revision ?? -1) >= reply.revision) {
      this.delays_ms.push(performance.now() - at_ms);
    } else {
      this.sent.push({ revision: reply.revision, at_ms });
    }
    if (reply.message !== '') session.notify(reply.message);
    return reply.revision;
  }
}
