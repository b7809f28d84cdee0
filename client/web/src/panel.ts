// The side of the page: patches, joints, and what else a session has. Rows are made once and kept, so that
// nothing that is being used goes away under the hand.

import { patchColor } from './colors';
import { h, icon } from './dom';
import type { Session } from './session';
import { edits, finite, type JointSetting, type PatchFit, type Verdict } from './wire';

export interface PanelTold {
  onChoose(patch: string | null): void;
  onHover(patch: string | null): void;
  /** A snapshot's name, or the rank of a minimum; false where it cannot be shown. */
  onGhost(of: string | number | null): Promise<boolean>;
  onKeep(name: string): void;
  initialOf(patch: string): string;
}

const kVerdicts: Record<Verdict, { sign: string; text: string; tone: string }> = {
  none: { sign: '–', text: 'off', tone: 'off' },
  reached: { sign: '✓', text: 'reached', tone: 'good' },
  at_limit: { sign: '▲', text: 'joint limit', tone: 'warn' },
  out_of_reach: { sign: '✕', text: 'out of reach', tone: 'bad' },
  normals_in_conflict: { sign: '⟲', text: 'faces away', tone: 'bad' },
};
const kHold = 100; // times the prior: firm, and contacts still have a say
const kFastest_ms = 80; // between two looks at the numbers
const kDegrees = 180 / Math.PI;

interface PatchRow {
  element: HTMLElement;
  mean: HTMLElement;
  bar: HTMLElement;
  verdict: HTMLElement;
  enabled: HTMLInputElement;
  details: HTMLElement;
  text: HTMLElement;
  weight: HTMLInputElement;
  suggest: HTMLButtonElement;
  button: HTMLButtonElement;
}

interface JointRow {
  element: HTMLElement;
  slider: HTMLInputElement;
  value: HTMLElement;
  lock: HTMLButtonElement;
  free: HTMLButtonElement;
  lower: HTMLInputElement;
  upper: HTMLInputElement;
  note: HTMLElement;
  range: HTMLElement;
}

const kLockIcon = 'M7 11V8a5 5 0 0 1 10 0v3M5 11h14v9H5z';

export class Panel {
  readonly patches = h('div', { class: 'list', role: 'list', 'aria-label': 'Patches' });
  readonly joints = h('div', { class: 'list', role: 'list', 'aria-label': 'Joints' });
  readonly minima = h('div', { class: 'list', 'aria-label': 'Minima' });
  readonly snapshots = h('div', { class: 'list', 'aria-label': 'Snapshots' });
  readonly facts = h('dl', { class: 'facts' });
  readonly weights = h('div', { class: 'weights' });
  private readonly differences = h('table', { class: 'differences', 'aria-label': 'What differs' });
  private readonly patchRows = new Map<string, PatchRow>();
  private readonly jointRows = new Map<string, JointRow>();
  private chosen: string | null = null;
  private ghost: string | number | null = null;
  private minimaKey = '';
  private weightsKey = '';
  private timer = 0;
  private shown_ms = 0;
  /** Of the page's, the one that is open. */
  tab = 'patches';

  constructor(
    private readonly session: Session,
    private readonly told: PanelTold,
  ) {}

  clear(): void {
    for (const list of [this.patches, this.joints, this.minima, this.snapshots, this.facts]) list.replaceChildren();
    this.patchRows.clear();
    this.jointRows.clear();
    this.weightsKey = this.minimaKey = '';
    this.ghost = null;
    this.differences.replaceChildren();
  }

  choose(patch: string | null): void {
    this.chosen = patch;
    for (const [name, row] of this.patchRows) {
      const isChosen = name === patch;
      row.element.classList.toggle('chosen', isChosen);
      row.button.setAttribute('aria-expanded', String(isChosen));
      row.details.hidden = !isChosen;
      if (isChosen) row.element.scrollIntoView({ block: 'nearest' });
    }
  }

  hover(patch: string | null): void {
    for (const [name, row] of this.patchRows) row.element.classList.toggle('hovered', name === patch);
  }

  /** What is seen of it, soon: poses come faster than anybody reads numbers. */
  show(): void {
    if (this.timer !== 0) return;
    const rest = kFastest_ms - (performance.now() - this.shown_ms);
    this.timer = window.setTimeout(() => this.showNow(), Math.max(0, rest));
  }

  showNow(): void {
    clearTimeout(this.timer);
    this.timer = 0;
    this.shown_ms = performance.now();
    if (this.tab === 'patches') this.showPatches();
    if (this.tab === 'joints') this.showJoints();
    if (this.tab !== 'more') return;
    this.showMinima();
    this.showSnapshots();
    this.showFacts();
    this.showWeights();
  }

  // === Patches

  private showPatches(): void {
    const fits = new Map((this.session.solution?.patches ?? []).map((fit) => [fit.name, fit]));
    const states = this.session.settings?.patches ?? [...fits.keys()].map((name) => ({ name, enabled: true, placed: true, weight: 1, reason: '' }));
    states.forEach((state, index) => {
      let row = this.patchRows.get(state.name);
      if (row === undefined) {
        row = this.makePatch(state.name, index);
        this.patchRows.set(state.name, row);
        this.patches.append(row.element);
      }
      this.fillPatch(row, state, fits.get(state.name));
    });
    for (const [name, row] of this.patchRows) {
      if (states.some((state) => state.name === name)) continue;
      row.element.remove();
      this.patchRows.delete(name);
    }
  }

  private makePatch(name: string, index: number): PatchRow {
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
      onchange: () => void this.session.edit(edits.enable(name, enabled.checked)),
    });
    const weight = h('input', {
      type: 'range',
      min: '-1',
      max: '1',
      step: '0.05',
      'aria-label': `weight of ${name}`,
      onchange: () => void this.session.edit(edits.patchWeight(name, Number((10 ** Number(weight.value)).toPrecision(2)))),
    });
    const turn = (label: string, title: string, side: 'object' | 'hand', degrees: number) =>
      h('button', { class: 'small', title, onclick: () => void this.session.edit(edits.turn(name, side, degrees / kDegrees)) }, label);
    const suggest = h('button', { class: 'small', title: 'A place nearby on the hand that suits it better', onclick: () => void this.suggest(name) }, 'Better place');
    const details = h(
      'div',
      { class: 'details', hidden: true },
      text,
      h('label', { class: 'line' }, 'Weight', weight),
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
    return { element, mean, bar, verdict, enabled, details, text, weight, suggest, button };
  }

  private fillPatch(row: PatchRow, state: { name: string; enabled: boolean; placed: boolean; reason: string; weight: number }, fit: PatchFit | undefined): void {
    const { motion } = this.session;
    // Of a motion it may be another one about the time that is shown.
    const here = this.session.editedHere([`enable ${state.name}`, `disable ${state.name}`]);
    const isOn = here === null ? state.enabled : here.startsWith('enable');
    const counts = (motion !== null || (state.enabled && state.placed)) && fit !== undefined;
    row.mean.textContent = counts ? `${fit.mean_mm.toFixed(1)} mm` : '';
    row.bar.style.setProperty('--length', counts ? `${Math.min(100, fit.mean_mm * 5)}%` : '0%');
    const isKnown = counts && this.session.solution?.is_diagnosed;
    const verdict = kVerdicts[isKnown ? fit.diagnosis.verdict : 'none'];
    row.verdict.textContent = !state.placed ? '✕ no place' : !isOn ? '– off' : motion !== null && !counts ? '– not now' : isKnown ? `${verdict.sign} ${verdict.text}` : '…';
    row.verdict.dataset['tone'] = !state.placed ? 'bad' : isKnown ? verdict.tone : 'off';
    row.bar.dataset['tone'] = row.verdict.dataset['tone'];
    row.element.classList.toggle('off', !counts);
    // Not from settings that are older than the last press of it.
    const { settings, state: now, underWay } = this.session;
    if (underWay === 0 && (settings === null || settings.state.revision === now?.revision)) row.enabled.checked = isOn;
    row.enabled.disabled = !this.session.mayEdit || !state.placed;
    const report = this.session.reports.find((one) => one.name === state.name);
    const lost = report?.lost.length ?? 0;
    row.text.textContent = [
      !state.placed ? state.reason : isKnown && fit.diagnosis.text !== '' ? `${fit.diagnosis.text}.` : '',
      counts && motion !== null
        ? `Normals ${fit.normal_deg.toFixed(0)}° apart.`
        : counts ? `Normals ${fit.normal_deg.toFixed(0)}° apart, farthest point ${fit.max_mm.toFixed(1)} mm.` : '',
      lost > 0 ? `${lost} of its points have no place on the hand.` : '',
    ]
      .filter((part) => part !== '')
      .join(' ');
    if (document.activeElement !== row.weight) row.weight.value = String(Math.log10(Math.max(0.1, state.weight)));
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
      await this.session.edit(edits.root(patch, 'hand', best.root_S));
      if (best.turned_rad !== 0) await this.session.edit(edits.turn(patch, 'hand', best.turned_rad));
      this.session.notify(`Moved by ${(1e3 * best.moved_m).toFixed(1)} mm.`);
    } catch (error) {
      this.session.failed(error);
    }
  }

  // === Joints

  private showJoints(): void {
    const settings = this.session.settings;
    if (settings === null) return;
    const solution = this.session.solution;
    const names = this.session.state?.joint_names ?? [];
    const limits = new Map((solution?.joints_at_limit ?? []).map((limit) => [limit.joint, limit.side]));
    settings.joints.forEach((joint) => {
      let row = this.jointRows.get(joint.name);
      if (row === undefined) {
        row = this.makeJoint(joint);
        this.jointRows.set(joint.name, row);
        this.joints.append(row.element);
      }
      const index = names.indexOf(joint.name);
      this.fillJoint(row, joint, solution?.joint_positions[index] ?? joint.value, limits.get(joint.name));
    });
    for (const [name, row] of this.jointRows) {
      if (settings.joints.some((joint) => joint.name === name)) continue;
      row.element.remove();
      this.jointRows.delete(name);
    }
  }

  private makeJoint(joint: JointSetting): JointRow {
    const { name } = joint;
    const scale = joint.kind === 'prismatic' ? 1e3 : kDegrees;
    const unit = joint.kind === 'prismatic' ? 'mm' : '°';
    const value = h('span', { class: 'number' });
    const note = h('span', { class: 'note' });
    const range = h('span', { class: 'range', 'aria-hidden': 'true' });
    let drag: ReturnType<Session['drag']> | null = null;
    const slider = h('input', {
      type: 'range',
      step: 'any',
      'aria-label': `${name}, in ${unit === '°' ? 'degrees' : 'mm'}`,
      oninput: () => {
        drag ??= this.session.drag();
        drag.move(edits.hold(name, Number(slider.value) / scale, kHold));
        value.textContent = `${Number(slider.value).toFixed(unit === '°' ? 0 : 1)}${unit}`;
      },
      onchange: () => {
        drag?.end();
        drag = null;
      },
    });
    const lock = h(
      'button',
      {
        class: 'icon',
        title: 'Lock: it stays as it is',
        'aria-label': `lock ${name}`,
        'aria-pressed': 'false',
        onclick: () => void this.session.edit(edits.lock(name, lock.getAttribute('aria-pressed') !== 'true')),
      },
      icon(kLockIcon),
    );
    const free = h(
      'button',
      { class: 'small', title: 'It was held by its slider; let it go', onclick: () => void this.session.edit(edits.hold(name, 0, 0)) },
      'let go',
    );
    const limit = (title: string) =>
      h('input', {
        type: 'number',
        step: 'any',
        title,
        'aria-label': `${title} of ${name}, in ${unit === '°' ? 'degrees' : 'mm'}`,
        onchange: () => this.setLimits(name, lower.value, upper.value, scale),
      });
    const lower = limit('lower limit');
    const upper = limit('upper limit');
    const reset = h(
      'button',
      {
        class: 'small',
        title: 'The limits of the hand’s model',
        onclick: () => {
          const now = this.session.settings?.joints.find((one) => one.name === name);
          if (now !== undefined) void this.session.edit(edits.limit(name, now.model_lower, now.model_upper));
        },
      },
      'reset',
    );
    const element = h(
      'div',
      { class: 'joint', role: 'listitem' },
      h('div', { class: 'line' }, h('span', { class: 'name' }, name), note, value, free, lock),
      h('div', { class: 'track' }, range, slider),
      h('details', {}, h('summary', {}, 'limits'), h('div', { class: 'line' }, lower, '–', upper, unit, reset)),
    );
    return { element, slider, value, lock, free, lower, upper, note, range };
  }

  private setLimits(joint: string, lower: string, upper: string, scale: number): void {
    const of = (text: string, otherwise: string) => (text.trim() === '' ? otherwise : Number(text) / scale);
    void this.session.edit(edits.limit(joint, of(lower, '-inf'), of(upper, 'inf')));
  }

  private fillJoint(row: JointRow, joint: JointSetting, position: number, limit: 'lower' | 'upper' | undefined): void {
    const scale = joint.kind === 'prismatic' ? 1e3 : kDegrees;
    const unit = joint.kind === 'prismatic' ? ' mm' : '°';
    const widest = joint.kind === 'prismatic' ? 0.2 : Math.PI;
    const from = Math.min(finite(joint.model_lower, -widest), finite(joint.lower, Infinity)) * scale;
    const to = Math.max(finite(joint.model_upper, widest), finite(joint.upper, -Infinity)) * scale;
    row.slider.min = String(from);
    row.slider.max = String(to);
    const digits = joint.kind === 'prismatic' ? 1 : 0;
    if (document.activeElement !== row.slider || !row.slider.matches(':active')) {
      row.slider.value = String(position * scale);
      row.value.textContent = `${(position * scale).toFixed(digits)}${unit}`;
    }
    const share = (x: number) => `${(100 * (x - from)) / Math.max(1e-9, to - from)}%`;
    row.range.style.setProperty('--from', share(finite(joint.lower, from / scale) * scale));
    row.range.style.setProperty('--to', share(finite(joint.upper, to / scale) * scale));
    const here = this.session.editedHere([`lock ${joint.name}`, `unlock ${joint.name}`]);
    const isLocked = here === null ? joint.locked : here.startsWith('lock');
    const gain = this.session.solution?.sensitivities.find((one) => one.limit.joint === joint.name);
    row.note.textContent = isLocked
      ? 'locked'
      : limit !== undefined
        ? `at its ${limit} limit${gain !== undefined && gain.gain_mm > 0.005 ? `: ${gain.gain_mm.toFixed(2)} mm nearer with ${(gain.given * scale).toFixed(digits)}${unit} more` : ''}`
        : joint.soft
          ? 'held'
          : '';
    row.element.classList.toggle('limited', limit !== undefined);
    row.free.hidden = !joint.soft;
    row.lock.setAttribute('aria-pressed', String(isLocked));
    row.element.classList.toggle('locked', isLocked);
    row.slider.disabled = !this.session.mayEdit || isLocked;
    row.lock.disabled = row.lower.disabled = row.upper.disabled = !this.session.mayEdit;
    for (const [input, limitNow] of [[row.lower, joint.lower], [row.upper, joint.upper]] as const) {
      if (document.activeElement !== input) input.value = typeof limitNow === 'number' ? (limitNow * scale).toFixed(1) : '';
    }
  }

  // === Minima, snapshots, facts

  private showMinima(): void {
    const solution = this.session.solution;
    if (solution === null) return;
    const key = JSON.stringify([solution.revision, solution.chosen_minimum, solution.minima.map((one) => one.terms.objective), this.ghost, this.session.mayEdit]);
    if (key === this.minimaKey) return;
    this.minimaKey = key;
    const best = solution.minima[0]?.terms.objective ?? 0;
    this.minima.replaceChildren(
      ...solution.minima.map((minimum, rank) =>
        h('div', { class: 'line' }, h(
          'button',
          {
            class: rank === solution.chosen_minimum ? 'choice wide chosen' : 'choice wide',
            disabled: !this.session.mayEdit || undefined,
            title: 'Take this pose',
            onclick: () => void this.session.edit(edits.choose(rank)),
          },
          h('span', { class: 'rank' }, String(rank + 1)),
          h('span', {}, `objective ${minimum.terms.objective.toPrecision(4)}`),
          h('span', { class: 'note' }, rank === 0 ? 'best' : `+${(minimum.terms.objective - best).toPrecision(2)}`),
          h('span', { class: 'note' }, `${minimum.hits} start${minimum.hits === 1 ? '' : 's'}`),
        ), this.session.link.isLive ? this.ghostButton(rank) : null), // the server says where its links are
      ),
    );
    if (solution.minima.length === 0) this.minima.append(h('p', { class: 'note' }, 'None were ranked.'));
  }

  private ghostButton(of: string | number): HTMLButtonElement {
    return h(
      'button',
      {
        class: 'small',
        'aria-pressed': String(this.ghost === of),
        'aria-label': `show ${typeof of === 'number' ? `solution ${of + 1}` : of} as a ghost`,
        title: 'Show its pose as a shell beside this one',
        onclick: async () => {
          const isShown = this.ghost !== of && (await this.told.onGhost(of));
          if (!isShown) await this.told.onGhost(null);
          this.ghost = isShown ? of : null;
          this.showMinima();
          this.showSnapshots();
        },
      },
      'ghost',
    );
  }

  /** It is not shown any more. */
  dropGhost(): void {
    this.ghost = null;
    this.show();
  }

  private showSnapshots(): void {
    const names = this.session.settings?.snapshots ?? [];
    this.snapshots.replaceChildren(
      ...names.map((name) =>
        h(
          'div',
          { class: 'line' },
          h('span', { class: 'name' }, name),
          this.ghostButton(name),
          h(
            'button',
            {
              class: 'small',
              disabled: !this.session.mayEdit || undefined,
              onclick: () => void this.session.edit(edits.restore(name)),
            },
            'go back to it',
          ),
          h('button', { class: 'small', title: 'What differs between it and now', hidden: !this.session.link.isLive || undefined, onclick: () => void this.compare(name) }, 'compare'),
        ),
      ),
    );
    const take = h(
      'button',
      {
        disabled: !this.session.mayEdit || undefined,
        onclick: () => {
          let number = 1;
          while (names.includes(`state-${number}`)) ++number;
          const name = `state-${number}`;
          this.told.onKeep(name);
          void this.session.edit(edits.snapshot(name)).then(() => this.session.notify(`Kept as “${name}”.`));
        },
      },
      'Keep this state',
    );
    this.snapshots.append(take, this.differences);
  }

  /** What changed from a snapshot to now, in the server's words. */
  private async compare(name: string): Promise<void> {
    try {
      const { differences } = await this.session.link.ask<{ differences: { what: string; a: string; b: string }[] }>({
        kind: 'compare',
        compare: { session_id: this.session.id, a: name, b: '' },
      });
      const row = (cell: 'th' | 'td', ...texts: string[]) => h('tr', {}, ...texts.map((text) => h(cell, {}, text)));
      this.differences.replaceChildren(
        ...(differences.length === 0
          ? [h('caption', {}, `Nothing differs from “${name}”.`)]
          : [row('th', '', name, 'now'), ...differences.map(({ what, a, b }) => row('td', what, a, b))]),
      );
    } catch (error) {
      this.session.failed(error);
    }
  }

  private showWeights(): void {
    const weights = this.session.settings?.weights;
    if (weights === undefined) return;
    const key = JSON.stringify([weights, this.session.mayEdit]);
    if (key === this.weightsKey || this.weights.contains(document.activeElement)) return;
    this.weightsKey = key;
    const names = [
      ['distance', 'Distance'],
      ['normal', 'Facing each other'],
      ['prior', 'Staying near the start'],
    ] as const;
    this.weights.replaceChildren(
      ...names.map(([name, text]) => {
        const input = h('input', {
          type: 'number',
          min: '0',
          step: 'any',
          value: String(weights[name]),
          disabled: !this.session.mayEdit || undefined,
          onchange: () => void this.session.edit(edits.weights({ ...weights, [name]: Number(input.value) })),
        });
        return h('label', { class: 'line' }, text, input);
      }),
    );
  }

  private showFacts(): void {
    const solution = this.session.solution;
    if (solution === null) return;
    const deep = solution.penetration;
    const facts: [string, string][] = [
      ['Objective', solution.terms.objective.toPrecision(5)],
      ['Outcome', `${solution.outcome.replaceAll('_', ' ')} by ${solution.solver}`],
      ['Inside the object', deep === null ? '…' : deep.max_depth_m > 0 ? `${(1e3 * deep.max_depth_m).toFixed(1)} mm at ${deep.links[0]?.link ?? ''}` : 'nowhere'],
      ['Inside itself', deep === null ? '…' : deep.self_depth_m > 0 ? `${(1e3 * deep.self_depth_m).toFixed(1)} mm` : 'nowhere'],
      ['Times', solution.times.map((time) => `${time.stage} ${time.duration_ms.toFixed(1)} ms`).join(', ')],
      ['Revision', String(solution.revision)],
    ];
    this.facts.replaceChildren(...facts.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]));
  }
}
