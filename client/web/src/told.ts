// What a session's pose came to, in the server's words, and what else it has to say: below the side, whatever is open there.

import { h } from './dom';
import type { Session } from './session';

export class Told {
  readonly element: HTMLElement;
  private readonly verdict = h('p');
  private readonly summary = h('summary');
  private readonly list = h('ul');
  private readonly notes = h('details', { open: !matchMedia('(width < 760px)').matches }, this.summary, this.list);

  constructor(private readonly session: Session) {
    // Keys scroll it, too.
    this.element = h('footer', { class: 'told', tabIndex: 0, role: 'region', 'aria-label': 'Verdict and notes' }, this.verdict, this.notes);
  }

  show(): void {
    const { solution, settings, state } = this.session;
    // While a pose has no verdict the last one stays, so that nothing jumps.
    if (state === null) this.verdict.textContent = '';
    else if (state.phase === 'failed') this.verdict.textContent = state.message;
    else if (this.session.countsNone) this.verdict.textContent = 'No contact counts: the pose before is shown.';
    else if (solution?.is_diagnosed) this.verdict.textContent = solution.verdict;
    const notes = state === null ? [] : (settings?.notes ?? []);
    if (notes.join('\n') !== [...this.list.children].map((one) => one.textContent).join('\n')) {
      this.list.replaceChildren(...notes.map((note) => h('li', {}, note)));
    }
    this.summary.textContent = notes.length === 1 ? '1 note' : `${notes.length} notes`;
    this.notes.hidden = notes.length === 0;
    this.verdict.hidden = this.verdict.textContent === '';
    this.element.hidden = this.verdict.hidden && this.notes.hidden;
  }
}
