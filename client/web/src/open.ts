// Which session: one that there is, or a new one.

import { h } from './dom';
import type { Session } from './session';
import type { ModelSummary, SessionState } from './wire';

export class OpenDialog {
  readonly element: HTMLDialogElement;
  private readonly list = h('div', { class: 'list' });
  private readonly chosen: Record<'hand' | 'object' | 'contacts', HTMLSelectElement>;
  private readonly note = h('p', { class: 'note', role: 'status' });
  private readonly make: HTMLButtonElement;

  constructor(private readonly session: Session) {
    const select = () => h('select', { required: true });
    this.chosen = { hand: select(), object: select(), contacts: select() };
    this.make = h('button', { class: 'main', onclick: () => void this.create() }, 'Grasp');
    this.element = h(
      'dialog',
      { 'aria-label': 'Open a session' },
      h('h2', {}, 'Open'),
      this.list,
      h('h2', {}, 'New'),
      h(
        'div',
        { class: 'form' },
        h('label', {}, 'Hand', this.chosen.hand),
        h('label', {}, 'Object', this.chosen.object),
        h('label', {}, 'Contacts', this.chosen.contacts),
      ),
      this.note,
      h('div', { class: 'line end' }, h('button', { onclick: () => this.element.close() }, 'Cancel'), this.make),
    );
    this.chosen.object.addEventListener('change', () => this.match());
  }

  async open(): Promise<void> {
    this.note.textContent = '';
    this.make.disabled = !this.session.mayEdit;
    this.element.showModal();
    try {
      const [sessions, models] = await Promise.all([
        this.session.link.ask<{ sessions: SessionState[] }>({ kind: 'list_sessions' }),
        this.session.link.ask<{ models: ModelSummary[] }>({ kind: 'list_models' }),
      ]);
      this.list.replaceChildren(
        ...sessions.sessions.map((one) =>
          h(
            'button',
            {
              class: 'choice',
              onclick: () => {
                this.element.close();
                void this.session.show(one.session_id);
              },
            },
            h('span', { class: 'rank' }, String(one.session_id)),
            h('span', {}, `${one.hand} grasps ${one.object}`),
            h('span', { class: 'note' }, one.last_edit),
          ),
        ),
      );
      if (sessions.sessions.length === 0) this.list.append(h('p', { class: 'note' }, 'The server has none yet.'));
      for (const kind of ['hand', 'object', 'contacts'] as const) {
        const had = this.chosen[kind].value;
        this.chosen[kind].replaceChildren(
          ...models.models.filter((model) => model.kind === kind).map((model) => h('option', { value: model.name, title: model.text }, model.name)),
        );
        if (had !== '') this.chosen[kind].value = had;
      }
      this.match();
    } catch (error) {
      this.note.textContent = error instanceof Error ? error.message : String(error);
    }
  }

  /** Contacts that are named after the object. */
  private match(): void {
    const object = this.chosen.object.value;
    const options = [...this.chosen.contacts.options];
    const found = options.find((option) => option.value.startsWith(object));
    if (found !== undefined) this.chosen.contacts.value = found.value;
  }

  private async create(): Promise<void> {
    this.make.disabled = true;
    this.note.textContent = 'Opening…';
    try {
      const state = await this.session.link.ask<SessionState>({
        kind: 'open_session',
        open_session: {
          hand: this.chosen.hand.value,
          object: this.chosen.object.value,
          contacts: this.chosen.contacts.value,
        },
      });
      this.element.close();
      await this.session.show(state.session_id);
    } catch (error) {
      this.note.textContent = error instanceof Error ? error.message : String(error);
    } finally {
      this.make.disabled = !this.session.mayEdit;
    }
  }
}
