// The patches of a session: how each is met, whether it counts, what turns and moves it. Rows are made once and kept.

import { patchColor } from './colors';
import { h } from './dom';
import type { Session } from './session';
import { edits, type PatchFit, type Verdict } from './wire';

export interface PatchListTold {
  onChoose(patch: string | null): void;
  onHover(patch: string | null): void;
  initialOf(patch: string): string;
}

const kVerdicts: Record<Verdict, { sign: string; text: string; tone: string }> = {
  none: { sign: '–', text: 'off', tone: 'off' },
  reached: { sign: '✓', text: 'reached', tone: 'good' },
  at_limit: { sign: '▲', text: 'joint limit', tone: 'warn' },
  out_of_reach: { sign: '✕', text: 'out of reach', tone: 'bad' },
  normals_in_conflict: { sign: '⟲', text: 'faces away', tone: 'bad' },
  no_clearance: { sign: '✕', text: 'finger too thick', tone: 'bad' },
};
const kInTheWay = { sign: '✕', text: 'others in the way', tone: 'warn' };
const kKeptAway = { sign: '✕', text: 'kept away', tone: 'warn' };
const kDegrees = 180 / Math.PI;

/** Out of reach only because of what else is asked for: alone it would be reached, or nearly. */
function isKeptAway({ diagnosis, mean_mm }: PatchFit): boolean {
  const { verdict, miss_m = 0, alone_mm = Infinity } = diagnosis;
  return verdict === 'out_of_reach' && 1e3 * miss_m + alone_mm <= mean_mm; // as the server's words have it (core/verdict)
}

/** What the slider says, which goes by powers of ten. */
const weightOf = (slider: HTMLInputElement): number => Number((10 ** Number(slider.value)).toPrecision(2));

/** What is too far is measured against that. */
function reachText({ diagnosis, mean_mm }: PatchFit): string {
  const { verdict, miss_m = 0 } = diagnosis;
  const isTooFar = (verdict === 'out_of_reach' || verdict === 'at_limit') && miss_m > 0;
  return isTooFar ? `Within ${(mean_mm - 1e3 * miss_m).toFixed(0)} mm on average it counts as reached.` : '';
}

interface PatchRow {
  element: HTMLElement;
  mean: HTMLElement;
  bar: HTMLElement;
  verdict: HTMLElement;
  enabled: HTMLInputElement;
  details: HTMLElement;
  text: HTMLElement;
  weight: HTMLInputElement;
  factor: HTMLElement;
  suggest: HTMLButtonElement;
  button: HTMLButtonElement;
}

export class PatchList {
  readonly element = h('div', { class: 'list', role: 'list', 'aria-label': 'Patches' });
  private readonly rows = new Map<string, PatchRow>();
  private chosen: string | null = null;

  constructor(
    private readonly session: Session,
    private readonly told: PatchListTold,
  ) {}

  clear(): void {
    this.element.replaceChildren();
    this.rows.clear();
  }

  choose(patch: string | null): void {
    this.chosen = patch;
    for (const [name, row] of this.rows) {
      const isChosen = name === patch;
      row.element.classList.toggle('chosen', isChosen);
      row.button.setAttribute('aria-expanded', String(isChosen));
      row.details.hidden = !isChosen;
      if (isChosen) row.element.scrollIntoView({ block: 'nearest' });
    }
  }

  hover(patch: string | null): void {
    for (const [name, row] of this.rows) row.element.classList.toggle('hovered', name === patch);
  }

  show(): void {
    const fits = new Map((this.session.solution?.patches ?? []).map((fit) => [fit.name, fit]));
    const states = this.session.settings?.patches ?? [...fits.keys()].map((name) => ({ name, enabled: true, placed: true, weight: 1, reason: '' }));
    states.forEach((state, index) => {
      let row = this.rows.get(state.name);
      if (row === undefined) {
        row = this.make(state.name, index);
        this.rows.set(state.name, row);
        this.element.append(row.element);
      }
      this.fill(row, state, fits.get(state.name));
    });
    for (const [name, row] of this.rows) {
      if (states.some((state) => state.name === name)) continue;
      row.element.remove();
      this.rows.delete(name);
    }
  }

  private make(name: string, index: number): PatchRow {
    const color = patchColor(name, index);
    const mean = h('span', { class: 'number' });
    const bar = h('span', { class: 'bar' });
    const verdict = h('span', { class: 'verdict' });
    const text = h('p');
    const enabled = h('input', {
      type: 'checkbox',
      class: 'switch',
      role: 'switch',
      title: 'Have this patch count, or not',
      'aria-label': `${name} counts`,
      onchange: () => void this.session.editing.edit(edits.enable(name, enabled.checked)),
    });
    const factor = h('output', { class: 'number' });
    const weight = h('input', {
      type: 'range',
      min: '-1',
      max: '1',
      step: '0.05',
      'aria-label': `weight of ${name}`,
      oninput: () => {
        factor.textContent = `× ${weightOf(weight)}`;
      },
      onchange: () => void this.session.editing.edit(edits.patchWeight(name, weightOf(weight))),
    });
    const turn = (label: string, title: string, side: 'object' | 'hand', degrees: number) =>
      h('button', { class: 'small', title, onclick: () => void this.session.editing.edit(edits.turn(name, side, degrees / kDegrees)) }, label);
    const suggest = h('button', { class: 'small', title: 'A place nearby on the hand that suits it better', onclick: () => void this.suggest(name) }, 'Better place');
    const details = h(
      'div',
      { class: 'details', hidden: true },
      text,
      h('label', { class: 'line' }, 'Weight', weight, factor),
      h(
        'div',
        { class: 'line' },
        'Turn on the hand',
        turn('⟲ 10°', 'Counter-clockwise, as seen from outside', 'hand', 10),
        turn('⟳ 10°', 'Clockwise, as seen from outside', 'hand', -10),
        suggest,
      ),
    );
    const button = h(
      'button',
      {
        class: 'row',
        'aria-expanded': 'false',
        onclick: () => this.told.onChoose(this.chosen === name ? null : name),
      },
      h('span', { class: 'dot', style: { background: color } }, this.told.initialOf(name)),
      h('span', { class: 'name' }, name),
      h('span', { class: 'meter' }, bar),
      mean,
      verdict,
    );
    const element = h(
      'div',
      {
        class: 'patch',
        role: 'listitem',
        onpointerenter: () => this.told.onHover(name),
        onpointerleave: () => this.told.onHover(null),
      },
      h('div', { class: 'head' }, button, enabled),
      details,
    );
    element.dataset['patch'] = name;
    return { element, mean, bar, verdict, enabled, details, text, weight, factor, suggest, button };
  }

  private fill(row: PatchRow, state: { name: string; enabled: boolean; placed: boolean; reason: string; weight: number }, fit: PatchFit | undefined): void {
    const { motion } = this.session;
    // Of a motion it may be another one about the time that is shown.
    const here = this.session.editedHere([`enable ${state.name}`, `disable ${state.name}`]);
    const isOn = here === null ? state.enabled : here.startsWith('enable');
    const isOnNow = motion === null ? state.enabled : this.session.isOn(state.name, this.session.time_s);
    const counts = isOnNow && (motion !== null || state.placed) && fit !== undefined;
    row.mean.textContent = counts ? `${fit.mean_mm.toFixed(1)} mm` : '';
    row.bar.style.setProperty('--length', counts ? `${Math.min(100, fit.mean_mm * 5)}%` : '0%');
    const isKnown = counts && this.session.solution?.is_diagnosed;
    const isHeld = (this.session.solution?.held ?? []).length > 0;
    const verdict = !isKnown || !isKeptAway(fit) ? kVerdicts[isKnown ? fit.diagnosis.verdict : 'none'] : isHeld ? kKeptAway : kInTheWay;
    row.verdict.textContent = !state.placed ? '✕ no place' : !isOnNow ? '– off' : motion !== null && (!counts || fit.diagnosis.verdict === 'none') ? '– not now' : isKnown ? `${verdict.sign} ${verdict.text}` : '…';
    row.verdict.dataset['tone'] = !state.placed ? 'bad' : isKnown ? verdict.tone : 'off';
    row.bar.dataset['tone'] = row.verdict.dataset['tone'];
    row.element.classList.toggle('off', !counts);
    // Not from settings that are older than the last press of it.
    const { settings, state: now, editing } = this.session;
    if (editing.underWay === 0 && (settings === null || settings.state.revision === now?.revision)) row.enabled.checked = isOn;
    row.enabled.disabled = !this.session.mayEdit || !state.placed;
    const report = this.session.reports.find((one) => one.name === state.name);
    const lost = report?.lost.length ?? 0;
    row.text.textContent = [
      !state.placed ? state.reason : isKnown && fit.diagnosis.text !== '' ? `${fit.diagnosis.text}.` : '',
      isKnown ? reachText(fit) : '',
      counts && motion !== null
        ? `Normals ${fit.normal_deg.toFixed(0)}° apart.`
        : counts ? `Normals ${fit.normal_deg.toFixed(0)}° apart, farthest point ${fit.max_mm.toFixed(1)} mm.` : '',
      lost > 0 ? `${lost} of its points have no place on the hand.` : '',
    ]
      .filter((part) => part !== '')
      .join(' ');
    if (document.activeElement !== row.weight) {
      row.weight.value = String(Math.log10(Math.max(0.1, state.weight)));
      row.factor.textContent = `× ${Number(state.weight.toPrecision(2))}`;
    }
    row.suggest.hidden = motion !== null; // it is the grasp's
    for (const control of row.details.querySelectorAll('button, input')) {
      (control as HTMLButtonElement).disabled = !this.session.mayEdit;
    }
  }

  private async suggest(patch: string): Promise<void> {
    try {
      const reply = await this.session.link.ask<{ suggestions: { root_S: never; turned_rad: number; moved_m: number }[] }>({
        kind: 'suggest',
        suggest: { session_id: this.session.id, patch, reach_m: 0.02, count: 1 },
      });
      const best = reply.suggestions[0];
      if (best === undefined) {
        this.session.notify('There is no better place nearby.');
        return;
      }
      await this.session.editing.edit(edits.root(patch, 'hand', best.root_S));
      if (best.turned_rad !== 0) await this.session.editing.edit(edits.turn(patch, 'hand', best.turned_rad));
      this.session.notify(`Moved by ${(1e3 * best.moved_m).toFixed(1)} mm.`);
    } catch (error) {
      this.session.failed(error);
    }
  }
}
