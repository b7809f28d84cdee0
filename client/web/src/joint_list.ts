// The joints of a session's hand: where each is in its range, held, locked, its limits. Rows are made once and kept, so that nothing that is
// being used goes away under the hand.

import type { Drag } from './drag';
import { h, icon } from './dom';
import type { Session } from './session';
import { edits, finite, type Extended, type JointSetting } from './wire';

// Times the prior, whose own weight is 0.001: the joint comes where it was put, and contacts give way. Tried on human20, tendon16 and barrett8
// on the lemon, joints moved by a third to two thirds of their range: at 1e2 and 1e4 they stay where they were, at 1e6 they stop 1 to 35
// degrees short, at 1e8 0.1 (one of them 2), at 1e9 0.02 (0.3).
const kHold = 1e9;
const kDegrees = 180 / Math.PI;
const kLockIcon = 'M7 11V8a5 5 0 0 1 10 0v3M5 11h14v9H5z';

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
  /** Limits that were asked for and that the settings do not tell yet. */
  asked: Limits | null;
}

type Limits = Record<'lower' | 'upper', Extended>;

export class JointList {
  readonly element = h('div', { class: 'list', role: 'list', 'aria-label': 'Joints' });
  private readonly rows = new Map<string, JointRow>();

  constructor(private readonly session: Session) {}

  clear(): void {
    this.element.replaceChildren();
    this.rows.clear();
  }

  show(): void {
    const settings = this.session.settings;
    if (settings === null) return;
    const solution = this.session.solution;
    const names = this.session.state?.joint_names ?? [];
    const limits = new Map((solution?.joints_at_limit ?? []).map((limit) => [limit.joint, limit.side]));
    settings.joints.forEach((joint) => {
      let row = this.rows.get(joint.name);
      if (row === undefined) {
        row = this.make(joint);
        this.rows.set(joint.name, row);
        this.element.append(row.element);
      }
      const index = names.indexOf(joint.name);
      this.fill(row, joint, solution?.joint_positions[index] ?? joint.value, limits.get(joint.name));
    });
    for (const [name, row] of this.rows) {
      if (settings.joints.some((joint) => joint.name === name)) continue;
      row.element.remove();
      this.rows.delete(name);
    }
  }

  private make(joint: JointSetting): JointRow {
    const { name } = joint;
    const scale = joint.kind === 'prismatic' ? 1e3 : kDegrees;
    const unit = joint.kind === 'prismatic' ? 'mm' : '°';
    const value = h('span', { class: 'number' });
    const note = h('span', { class: 'note' });
    const range = h('span', { class: 'range', 'aria-hidden': 'true' });
    let drag: Drag | null = null;
    const slider = h('input', {
      type: 'range',
      step: 'any',
      'aria-label': `${name}, in ${unit === '°' ? 'degrees' : 'mm'}`,
      oninput: () => {
        drag ??= this.session.editing.drag();
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
        onclick: () => void this.session.editing.edit(edits.lock(name, lock.getAttribute('aria-pressed') !== 'true')),
      },
      icon(kLockIcon),
    );
    const free = h(
      'button',
      { class: 'small', title: 'It was held by its slider; let it go', onclick: () => void this.session.editing.edit(edits.hold(name, 0, 0)) },
      'let go',
    );
    const limit = (side: keyof Limits) => {
      const input = h('input', {
        type: 'number',
        step: 'any',
        title: `${side} limit`,
        'aria-label': `${side} limit of ${name}, in ${unit === '°' ? 'degrees' : 'mm'}`,
        onchange: () => {
          const none = side === 'lower' ? '-inf' : 'inf';
          void this.setLimit(name, side, input.value.trim() === '' ? none : Number(input.value) / scale);
        },
      });
      return input;
    };
    const lower = limit('lower');
    const upper = limit('upper');
    const reset = h(
      'button',
      {
        class: 'small',
        title: 'The limits of the hand’s model',
        onclick: () => {
          const now = this.session.settings?.joints.find((one) => one.name === name);
          if (now !== undefined) void this.setLimits(name, { lower: now.model_lower, upper: now.model_upper });
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
    return { element, slider, value, lock, free, lower, upper, note, range, asked: null };
  }

  /** One of them; the other stays as it is in force, to the last digit. */
  private setLimit(joint: string, side: keyof Limits, value: Extended): Promise<void> {
    const now = this.rows.get(joint)?.asked ?? this.session.settings?.joints.find((one) => one.name === joint);
    return now === undefined || now === null ? Promise.resolve() : this.setLimits(joint, { lower: now.lower, upper: now.upper, [side]: value });
  }

  private async setLimits(joint: string, limits: Limits): Promise<void> {
    const row = this.rows.get(joint);
    if (row !== undefined) row.asked = limits;
    const isTaken = await this.session.editing.edit(edits.limit(joint, limits.lower, limits.upper));
    if (row !== undefined && !isTaken) row.asked = null;
  }

  private fill(row: JointRow, joint: JointSetting, position: number, limit: 'lower' | 'upper' | undefined): void {
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
    const atLimit =
      limit === undefined
        ? ''
        : `at its ${limit} limit${gain !== undefined && gain.gain_mm > 0.005 ? `: ${gain.gain_mm.toFixed(2)} mm nearer with ${(gain.given * scale).toFixed(digits)}${unit} more` : ''}`;
    // What was asked for: where the hand cannot have it, the joint stands elsewhere.
    const held = joint.soft ? `held at ${(joint.prior * scale).toFixed(digits)}${unit}` : '';
    row.note.textContent = isLocked ? 'locked' : [held, atLimit].filter((text) => text !== '').join(', ');
    row.element.classList.toggle('limited', limit !== undefined);
    row.free.hidden = !joint.soft;
    row.lock.setAttribute('aria-pressed', String(isLocked));
    row.element.classList.toggle('locked', isLocked);
    row.slider.disabled = !this.session.mayEdit || isLocked;
    row.lock.disabled = row.lower.disabled = row.upper.disabled = !this.session.mayEdit;
    const { settings, state, editing } = this.session;
    if (editing.underWay === 0 && settings?.state.revision === state?.revision) row.asked = null;
    for (const [input, limitNow] of [[row.lower, joint.lower], [row.upper, joint.upper]] as const) {
      if (document.activeElement !== input) input.value = typeof limitNow === 'number' ? (limitNow * scale).toFixed(1) : '';
    }
  }
}
