// What is asked of the server about a session: its models, its settings, the points its patches lost.

import type { Session } from './session';
import type { HandDescription, PatchInfo, PatchReport, SessionSettings } from './wire';

const kLookAgain_ms = 250; // settings, while edits follow each other

export class Lookup {
  private loaded = ''; // of which session's models
  private lookAgain = false; // asked for while the last answer was on its way
  private lookTimer = 0;
  private looking = 0; // at which session

  constructor(private readonly session: Session) {}

  /** The session's models, when they are others than before. */
  async models(): Promise<void> {
    const { session } = this;
    const { state } = session;
    if (state === null) return;
    const key = `${state.hand}\n${state.object}\n${state.contacts}\n${state.motion}`;
    if (key === this.loaded) return;
    this.loaded = key;
    try {
      const [hand, object, contacts] = await Promise.all([
        session.link.describe<HandDescription>('hand', state.hand),
        session.link.describe<{ name: string }>('object', state.object),
        session.isOfMotion
          ? session.frames.patchesOf(state.motion)
          : session.link.describe<{ name: string; patches: PatchInfo[] }>('contacts', state.contacts),
      ]);
      if (this.loaded !== key) return;
      session.models = { hand, object, contacts };
      session.tell('models');
      this.soon();
    } catch (error) {
      this.loaded = '';
      session.failed(error);
    }
  }

  /** Has the settings asked for, soon, and again while edits come. */
  soon(): void {
    const { session } = this;
    if (session.isOfMotion && session.motion === null) return;
    this.lookAgain = this.looking === session.id;
    if (this.lookTimer !== 0 || this.lookAgain) return;
    this.lookTimer = window.setTimeout(() => void this.now(), session.settings === null ? 0 : kLookAgain_ms);
  }

  private async now(): Promise<void> {
    const { session } = this;
    this.lookTimer = 0;
    this.lookAgain = false;
    const key = session.id;
    this.looking = key;
    const seen = session.solution?.sequence_number;
    try {
      const named = { session_id: key };
      const [settings, transfer] = await Promise.all([
        session.link.ask<SessionSettings>({ kind: 'session_settings', session: named }),
        // Of a motion its frames tell more.
        session.isOfMotion ? { patches: [] } : session.link.ask<{ patches: PatchReport[] }>({ kind: 'transfer', session: named }),
      ]);
      // A session that has moved meanwhile is looked at under its new number.
      if (key !== session.id) return;
      session.settings = settings;
      session.reports = transfer.patches;
      session.tell('settings');
    } catch (error) {
      if (key !== session.id) return;
      session.failed(error);
    } finally {
      if (this.looking === key) this.looking = 0;
    }
    if (session.motion !== null) {
      const isOld = session.settings !== null && session.settings.state.revision < (session.state?.revision ?? 0);
      if (this.lookAgain || isOld) this.soon();
      return;
    }
    if (this.lookAgain || seen !== session.solution?.sequence_number) this.soon();
  }
}
