// Which session: one that there is, or a new one, of what the server has or of files.

import { h } from './dom';
import { asKind, chosen, savedSession, sorted, type Given, type GivenFile, type Kind } from './files';
import { Refusal } from './link';
import type { Session } from './session';
import { said } from './words';
import type { ModelSummary, SessionState } from './wire';

const kUnits = { m: 'metres', cm: 'centimetres', mm: 'millimetres', in: 'inches' };
const kTitles = { hand: 'Hand', object: 'Object', contacts: 'Contacts' };
const kAccepted = {
  hand: '.urdf,.zip,.stl,.obj,.dae,.ply,.glb,.gltf,.srdf,.yaml',
  object: '.obj,.stl,.ply,.glb,.gltf,.dae,.zip',
  contacts: '.json,.ply,.glb,.gltf,.obj,.zip',
};
/** Of what the server brings along, the grasp that everything is reached in. */
const kFirst = { hand: 'human20', object: 'lemon', contacts: 'lemon_6' };
/** Contacts of an object that suit a hand better than the others. */
const kSuited: Record<string, string> = { 'barrett8 lemon': 'lemon_3' };

/** Of what the contacts are chosen from, a motion. */
const kMotion = 'motion ';
const kMostText = 2 * 2 ** 20 - 1024; // bytes of a session's file as the gateway takes them, in one message

let lastGroup = 0;

/** A hand, an object or contacts: chosen among those that the server has, or given as files. */
class Part {
  readonly select = h('select', { required: true });
  readonly element: HTMLElement;
  isBusy = false;
  private isRefused = false;
  private readonly note = h('p', { class: 'note', role: 'status', 'aria-live': 'polite', hidden: true });
  private readonly mains = h('select', { 'aria-label': 'which of the files' });
  private readonly units = h('select', { 'aria-label': 'its units' }, ...Object.entries(kUnits).map(([value, text]) => h('option', { value }, text)));
  private readonly mainLine = h('label', { class: 'line', hidden: true }, 'Read first', this.mains);
  private readonly unitsLine = h(
    'div',
    { class: 'line', hidden: true },
    'It is in',
    this.units,
    h('button', { type: 'button', class: 'small', onclick: () => void this.load(this.units.value) }, 'Yes'),
  );
  private given: Given | null = null;
  private group = 0;
  private turn = 0; // what was given last counts

  constructor(
    readonly kind: Kind,
    private readonly session: Session,
    private readonly objectOf: () => string,
    private readonly changed: () => void,
    private readonly openSaved: (file: GivenFile) => void,
  ) {
    const title = kTitles[kind].toLowerCase();
    const input = h('input', {
      type: 'file',
      multiple: true,
      accept: kAccepted[kind],
      hidden: true,
      'aria-label': `files of the ${title}`,
      onchange: () => void this.choose(input),
    });
    const folder = h('input', { type: 'file', hidden: true, 'aria-label': `folder of the ${title}`, onchange: () => void this.choose(folder) });
    folder.webkitdirectory = true;
    const of = (text: string, what: HTMLInputElement) =>
      h('button', { type: 'button', class: 'small', 'aria-label': `${text.replace('…', '')} of the ${title}`, onclick: () => what.click() }, text);
    this.element = h(
      'div',
      { class: 'part' },
      h('label', {}, kTitles[kind], this.select),
      h('div', { class: 'line' }, 'or', of('File…', input), kind === 'contacts' ? null : of('Folder…', folder), input, folder),
      this.note,
      this.mainLine,
      this.unitsLine,
    );
    this.element.dataset['kind'] = kind;
    this.select.addEventListener('change', () => {
      this.clear(); // one of the server's instead
      this.changed();
    });
    this.mains.addEventListener('change', () => void this.load(''));
  }

  /** Those that the server has. */
  offer(models: ModelSummary[]): void {
    const had = this.select.value;
    const of = (kind: ModelSummary['kind'], before = '') =>
      models.filter((model) => model.kind === kind).map((model) => h('option', { value: before + model.name, title: model.text }, model.name));
    this.select.replaceChildren(...of(this.kind));
    const motions = this.kind === 'contacts' ? of('motion', kMotion) : [];
    if (motions.length > 0) this.select.append(h('optgroup', { label: 'Motions' }, ...motions));
    const names = [...this.select.options].map((option) => option.value);
    if (this.isRefused) this.select.selectedIndex = -1;
    else this.select.value = names.includes(had) ? had : names.includes(kFirst[this.kind]) ? kFirst[this.kind] : (names[0] ?? '');
  }

  /** Files take the place of what was chosen: sent, and read by the server. */
  async give(given: Given): Promise<void> {
    this.forget();
    const turn = ++this.turn;
    const group = ++lastGroup;
    this.given = given;
    this.group = group;
    this.mains.replaceChildren(...given.mains.map((path) => h('option', { value: path }, path)));
    this.mainLine.hidden = given.mains.length < 2;
    this.unitsLine.hidden = true;
    this.setBusy(true);
    try {
      const total = given.files.reduce((sum, { file }) => sum + file.size, 0);
      let before = 0;
      for (const { path, file } of given.files) {
        await this.session.link.give(group, path, file, (bytes) => {
          this.tell(`Sending ${path}: ${Math.round((100 * (before + bytes)) / Math.max(1, total))} %`);
        });
        if (turn !== this.turn) return;
        before += file.size;
      }
      await this.load('');
    } catch (error) {
      if (turn !== this.turn) return;
      this.refuse(error);
      this.setBusy(false);
    }
  }

  get isGiven(): boolean {
    return this.given !== null;
  }

  /** The files again: contacts, of another object. */
  async again(): Promise<void> {
    if (this.given !== null && !this.isBusy) await this.load(this.unitsLine.hidden ? '' : this.units.value);
  }

  /** What is wrong with what was to be given: nothing is chosen until that is mended, or something else is. */
  private refuse(error: unknown): void {
    this.tell(error instanceof Error ? error.message : String(error), 'bad');
    this.isRefused = true;
    this.select.selectedIndex = -1;
  }

  /** Nothing was given, and nothing is told of it. */
  clear(): void {
    this.forget();
    this.isRefused = false;
    this.note.hidden = this.mainLine.hidden = this.unitsLine.hidden = true;
  }

  forget(): void {
    if (this.group !== 0) this.session.link.forget(this.group);
    this.group = 0;
    this.given = null;
  }

  private async choose(input: HTMLInputElement): Promise<void> {
    const list = input.files;
    if (list === null || list.length === 0) return;
    this.tell('Reading…');
    try {
      const files = await chosen(list);
      const saved = await savedSession(files);
      if (saved !== undefined) this.openSaved(saved);
      else await this.give(asKind(this.kind, files));
    } catch (error) {
      this.refuse(error);
      this.changed();
    }
    input.value = ''; // the same file once more is a change, too
  }

  private async load(units: string): Promise<void> {
    const turn = ++this.turn;
    const main = this.mains.value;
    this.setBusy(true);
    this.tell(`The server reads ${main}…`);
    try {
      const model = await this.session.link.load(this.group, this.kind, main, this.kind === 'contacts' ? this.objectOf() : '', units);
      if (turn !== this.turn) return;
      if (![...this.select.options].some((option) => option.value === model.name)) {
        this.select.add(h('option', { value: model.name, title: model.text }, model.name), this.select.querySelector('optgroup'));
      }
      this.select.value = model.name;
      this.isRefused = false;
      this.tell(`✓ ${main}: ${model.text}`, 'good');
      this.changed();
    } catch (error) {
      if (turn !== this.turn) return;
      const text = error instanceof Error ? error.message : String(error);
      const isOfUnits = error instanceof Refusal && error.code === 'units';
      if (isOfUnits) {
        this.units.value = /--units (mm|cm|in|m)\b/.exec(text)?.[1] ?? 'mm';
        this.unitsLine.hidden = false;
      }
      this.refuse(isOfUnits ? `${text.split(': say --units')[0]!}: say which.` : text);
    } finally {
      if (turn === this.turn) this.setBusy(false);
    }
  }

  private setBusy(isBusy: boolean): void {
    this.isBusy = isBusy;
    this.changed();
  }

  private tell(text: string, tone = 'off'): void {
    this.note.hidden = false;
    this.note.textContent = text;
    this.note.dataset['tone'] = tone;
  }
}

export class OpenDialog {
  readonly element: HTMLDialogElement;
  private readonly list = h('div', { class: 'list' });
  private readonly parts: Record<Kind, Part>;
  private readonly note = h('p', { class: 'note', role: 'status' });
  private readonly make: HTMLButtonElement;
  private readonly form: HTMLElement;
  private readonly saved: HTMLElement;
  private object = '';
  private hand = '';

  constructor(private readonly session: Session) {
    const part = (kind: Kind) =>
      new Part(kind, session, () => this.parts.object.select.value, () => this.changed(), (file) => void this.openSaved(file));
    this.parts = { hand: part('hand'), object: part('object'), contacts: part('contacts') };
    this.make = h('button', { class: 'main', onclick: () => void this.create() }, 'Grasp');
    this.form = h(
      'div',
      {},
      h('h2', {}, 'A new one'),
      h('p', { class: 'note' }, 'Choose of what the server has, or give files: they can be dropped anywhere on the page, a hand as its folder or a zip.'),
      h('div', { class: 'form' }, this.parts.hand.element, this.parts.object.element, this.parts.contacts.element),
    );
    const saved = h('input', {
      type: 'file',
      accept: '.json',
      hidden: true,
      'aria-label': 'file of a session',
      onchange: () => {
        const file = saved.files?.[0];
        if (file !== undefined) void this.openSaved({ path: file.name, file });
        saved.value = ''; // the same file once more is a change, too
      },
    });
    this.saved = h('div', { class: 'line' }, h('button', { class: 'small', onclick: () => saved.click() }, 'Saved session…'), saved);
    this.element = h(
      'dialog',
      { 'aria-label': 'Open a session' },
      h('h2', {}, 'Sessions that there are'),
      this.list,
      this.saved,
      this.form,
      this.note,
      h('div', { class: 'line end' }, h('button', { onclick: () => this.element.close() }, 'Cancel'), this.make),
    );
    this.element.addEventListener('close', () => {
      for (const one of Object.values(this.parts)) one.clear();
    });
  }

  async open(): Promise<void> {
    this.note.textContent = '';
    this.form.hidden = this.saved.hidden = this.make.hidden = !this.session.mayOpen;
    if (!this.element.open) this.element.showModal();
    try {
      const [sessions, models] = await Promise.all([
        this.session.link.ask<{ sessions: SessionState[] }>({ kind: 'list_sessions' }),
        this.session.link.ask<{ models: ModelSummary[] }>({ kind: 'list_models' }),
      ]);
      this.list.replaceChildren(
        ...sessions.sessions.map((one, index) =>
          h(
            'button',
            {
              class: 'choice',
              onclick: () => {
                this.element.close();
                void this.session.show(one.session_id);
              },
            },
            h('span', { class: 'rank', title: `session ${one.session_id}` }, String(index + 1)),
            h('span', {}, one.motion === '' ? `${one.hand} grasps ${one.object} by ${one.contacts}` : `${one.hand} follows ${one.motion} with ${one.object}`),
            h('span', { class: 'note' }, said(one.last_edit)),
          ),
        ),
      );
      if (sessions.sessions.length === 0) this.list.append(h('p', { class: 'note' }, 'None yet.'));
      for (const one of Object.values(this.parts)) one.offer(models.models);
      this.object = this.parts.object.select.value;
      this.hand = this.parts.hand.select.value;
      this.changed();
    } catch (error) {
      this.fail(error);
    }
  }

  /** Files that were dropped: each where it belongs, contacts once there is their object. */
  async take(files: Promise<GivenFile[]>): Promise<void> {
    files.catch(() => undefined); // told below, when the dialog is there
    await this.open();
    try {
      delete this.note.dataset['tone'];
      this.note.textContent = 'Reading…';
      const all = await files;
      const saved = await savedSession(all);
      if (saved !== undefined) return await this.openSaved(saved);
      const given = await sorted(all);
      this.note.textContent = '';
      const of = (kind: Kind) => given.find((one) => one.kind === kind);
      const give = async (one: Given | undefined) => one !== undefined && (await this.parts[one.kind].give(one));
      await Promise.all([give(of('hand')), give(of('object'))]);
      await give(of('contacts'));
    } catch (error) {
      this.fail(error);
    }
  }

  private fail(error: unknown): void {
    this.note.dataset['tone'] = 'bad';
    this.note.textContent = error instanceof Error ? error.message : String(error);
  }

  private changed(): void {
    const object = this.parts.object.select.value;
    const hand = this.parts.hand.select.value;
    this.make.disabled = Object.values(this.parts).some((part) => part.isBusy || part.select.value === '');
    if (object === '' || hand === '') return;
    const isOther = object !== this.object;
    if (!isOther && hand === this.hand) return;
    [this.object, this.hand] = [object, hand];
    if (this.parts.contacts.isGiven) {
      if (isOther) void this.parts.contacts.again();
    } else {
      this.match(hand, object, isOther);
    }
  }

  /** Contacts that suit the hand, else those that are named after the object. */
  private match(hand: string, object: string, isOther: boolean): void {
    const { select } = this.parts.contacts;
    const names = [...select.options].map((option) => option.value);
    const suited = kSuited[`${hand} ${object}`];
    const named = names.filter((name) => name.startsWith(object) && !Object.values(kSuited).includes(name));
    if (suited !== undefined && names.includes(suited)) select.value = suited;
    else if ((isOther || Object.values(kSuited).includes(select.value)) && named[0] !== undefined) select.value = named[0];
  }

  private create(): Promise<void> {
    const of = (kind: Kind) => this.parts[kind].select.value;
    const chosen = of('contacts');
    const by = chosen.startsWith(kMotion) ? { motion: chosen.slice(kMotion.length) } : { contacts: chosen };
    return this.begin({ kind: 'open_session', open_session: { hand: of('hand'), object: of('object'), ...by } });
  }

  /** A session that was saved, as Save writes it. */
  private async openSaved({ path, file }: GivenFile): Promise<void> {
    const body = { kind: 'load_session', load_session: { text: await file.text() } };
    if (new Blob([JSON.stringify(body)]).size > kMostText) this.fail(`${path} is larger than a page may send: \`handgraft session open\` opens it.`);
    else await this.begin(body);
  }

  private async begin(body: Record<string, unknown>): Promise<void> {
    this.make.disabled = true;
    delete this.note.dataset['tone'];
    this.note.textContent = 'Opening…';
    try {
      const state = await this.session.link.ask<SessionState>(body);
      this.element.close();
      await this.session.show(state.session_id);
    } catch (error) {
      this.fail(error);
    } finally {
      this.changed();
    }
  }
}
