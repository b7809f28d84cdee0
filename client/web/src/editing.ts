// What is done to a session: edits, drags, their undo; and how long each takes to its pose.

import { aimed } from './aim';
import { Drag } from './drag';
import { Refusal } from './link';
import type { Session } from './session';
import { edits, type EditBody, type EditTime } from './wire';

const kMostInFlight = 3; // of one drag, before the first of them is answered
const kMove_ms = 5000; // until a session that its server lost has another number

export class Editing {
  /** Drags and edits that are not answered yet. */
  underWay = 0;
  /** From an edit's sending to its pose, in ms. */
  readonly delays_ms: number[] = [];

  /** Edits that were made as one: a drag. Undone as one, too. */
  private readonly groups: { from: number; to: number }[] = [];
  private readonly sent: { revision: number; at_ms: number }[] = [];

  constructor(private readonly session: Session) {}

  /** Another session, or none. */
  forget(): void {
    this.groups.length = 0;
  }

  /** The same session under another number: what was on its way is not answered any more. */
  restart(): void {
    this.forget();
    this.sent.length = 0;
  }

  /** One edit; refusals are told. */
  async edit(body: EditBody): Promise<boolean> {
    const { session } = this;
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

  async undo(): Promise<void> {
    if (!this.mayUndo) return;
    const last = this.groups.at(-1);
    const revision = this.session.state?.revision ?? 0;
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
    const { session } = this;
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
        if (to > from + 1) this.groups.push({ from, to });
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
    const reply = await session.link.edit(id, body, when).catch(async (error: unknown) => {
      // A server that has just come back opens the session anew, under another number.
      const isGone = error instanceof Refusal && error.code === 'not_found' && error.message.startsWith(`session ${id} `);
      for (let waited = 0; isGone && session.id === id && waited < kMove_ms; waited += 100) await new Promise((resolve) => setTimeout(resolve, 100));
      if (!isGone || session.id === id) throw error;
      return session.link.edit(session.id, body, when);
    });
    if ((session.solution?.revision ?? -1) >= reply.revision) {
      this.delays_ms.push(performance.now() - at_ms);
    } else {
      this.sent.push({ revision: reply.revision, at_ms });
    }
    if (reply.message !== '') session.notify(reply.message);
    return reply.revision;
  }
}
