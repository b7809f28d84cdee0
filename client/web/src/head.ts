// The head of the page: what is grasped, how well, who else is here; undo, opening, saving.

import { h, icon } from './dom';
import { saveAs, type Format } from './export';
import { kIcons } from './icons';
import type { Session } from './session';
import type { Stage } from './stage';
import { saidBy } from './words';

export interface HeadTold {
  onOpen(): void;
  onFrame(): void;
  onTheme(): void;
  onSide(): void;
}

const kFormats: [Format, string][] = [
  ['png', 'Picture (PNG)'],
  ['link', 'Copy the link'],
  ['html', 'Page as one file (HTML)'],
  ['session', 'Session (JSON)'],
  ['json', 'Pose (JSON)'],
  ['csv', 'Table (CSV)'],
  ['glb', 'Scene (glTF)'],
];

function button(name: keyof typeof kIcons, text: string, act: () => void): HTMLButtonElement {
  return h('button', { class: 'icon', title: text, 'aria-label': text, onclick: act }, icon(kIcons[name]));
}

export class Head {
  readonly element: HTMLElement;
  private readonly title = h('h1', {}, 'Handgraft');
  private readonly verdict = h('span', { class: 'pill' });
  private readonly people = h('span', { class: 'people' });
  private readonly undo: HTMLButtonElement;
  private readonly redo: HTMLButtonElement;
  private readonly openButton: HTMLButtonElement;
  private readonly menu = h('details', { class: 'menu' });
  private readonly menuButton = h('summary', { title: 'Save', 'aria-label': 'Save', role: 'button', class: 'icon' }, icon(kIcons.save));

  constructor(
    private readonly session: Session,
    stage: Stage,
    told: HeadTold,
  ) {
    this.undo = button('undo', 'Undo (Ctrl+Z)', () => session.editing.undo());
    this.redo = button('redo', 'Redo (Ctrl+Y)', () => session.editing.redo());
    this.openButton = h('button', { onclick: () => told.onOpen() }, 'Open…');
    const items = kFormats.map(([format, text]) => {
      const isHere = format === 'png' || session.link.isLive;
      const save = () => {
        this.menu.open = false;
        void saveAs(format, session, stage).catch((error: unknown) => session.failed(error));
      };
      return h('button', { role: 'menuitem', hidden: !isHere || undefined, onclick: save }, text);
    });
    this.menu.append(this.menuButton, h('div', { class: 'items', role: 'menu' }, ...items));
    // A press anywhere else closes it.
    window.addEventListener('pointerdown', (event) => {
      if (this.menu.open && !this.menu.contains(event.target as Node)) this.menu.open = false;
    }, { capture: true });
    this.element = h(
      'header',
      {},
      this.title,
      this.verdict,
      h('span', { class: 'space' }),
      this.people,
      this.undo,
      this.redo,
      this.openButton,
      this.menu,
      button('frame', 'Show all (F)', () => told.onFrame()),
      button('theme', 'Light or dark', () => told.onTheme()),
      button('panel', 'Show or hide the side', () => told.onSide()),
    );
  }

  get isMenuOpen(): boolean {
    return this.menu.open;
  }

  closeMenu(): void {
    this.menu.open = false;
    this.menuButton.focus();
  }

  show(): void {
    const { session, title, verdict, people } = this;
    const { state, solution } = session;
    const isOpen = state !== null;
    document.title = isOpen ? `${state.hand} grasps ${state.object} – Handgraft` : 'Handgraft';
    title.textContent = isOpen ? `${state.hand} grasps ${state.object}` : 'Handgraft';
    title.title = isOpen ? `session ${session.id}, by ${state.motion || state.contacts}` : '';
    const { text, tone } = this.standing();
    verdict.hidden = !isOpen || solution === null;
    verdict.textContent = text;
    verdict.title = solution?.verdict ?? '';
    verdict.dataset['tone'] = tone;
    const others = session.pages.filter((one) => one.page !== session.page && one.sessions.includes(session.id));
    const last = state !== null && state.last_edit !== '' && session.editor !== '' ? saidBy(session.editor, state.last_edit) : '';
    people.textContent = [others.length > 0 ? `${others.length + 1} pages here` : '', last].filter((text) => text !== '').join(' · ');
    people.title = others.map((one) => session.nameOf(one.page)).join(', ');
    this.undo.disabled = !session.editing.mayUndo;
    this.redo.disabled = !session.mayEdit || (state?.redo_count ?? 0) === 0;
    this.openButton.hidden = !session.link.isLive;
  }

  /** How many of the contacts that count are reached; those without a place on the hand count, too. */
  private standing(): { text: string; tone: 'off' | 'good' | 'warn' } {
    const { solution, settings, motion } = this.session;
    if (this.session.countsNone) return { text: 'no contact counts', tone: 'off' };
    if (!solution?.is_diagnosed) return { text: 'solving…', tone: 'off' };
    const fits = solution.patches.filter((fit) => fit.diagnosis.verdict !== 'none');
    const reached = fits.filter((fit) => fit.diagnosis.verdict === 'reached').length;
    const homeless = motion !== null ? 0 : (settings?.patches ?? []).filter((one) => one.enabled && !one.placed).length;
    const all = fits.length + homeless;
    if (all === 0) return { text: 'no contact', tone: 'off' };
    const text = homeless === 0 ? `${reached} of ${all} reached` : `${reached} of ${all}; ${homeless} ${homeless === 1 ? 'has' : 'have'} no place`;
    return { text, tone: reached === all ? 'good' : 'warn' };
  }
}
