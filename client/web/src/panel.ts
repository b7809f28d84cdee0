// The side of the page: patches, joints, and what else a session has; what is seen of it is kept up to date.

import { h } from './dom';
import { JointList } from './joint_list';
import { PatchList, type PatchListTold } from './patch_list';
import type { Session } from './session';
import { edits } from './wire';

export interface PanelTold extends PatchListTold {
  /** A snapshot's name, or the rank of a minimum; false where it cannot be shown. */
  onGhost(of: string | number | null): Promise<boolean>;
  onKeep(name: string): void;
}

const kFastest_ms = 80; // between two looks at the numbers

export class Panel {
  readonly patches: PatchList;
  readonly joints: JointList;
  readonly minima = h('div', { class: 'list', 'aria-label': 'Minima' });
  readonly snapshots = h('div', { class: 'list', 'aria-label': 'Snapshots' });
  readonly facts = h('dl', { class: 'facts' });
  readonly weights = h('div', { class: 'weights' });
  private readonly differences = h('table', { class: 'differences', 'aria-label': 'What differs' });
  private ghost: string | number | null = null;
  private readonly keeping = new Set<string>(); // states that the settings may not tell yet
  private minimaKey = '';
  private weightsKey = '';
  private timer = 0;
  private shown_ms = 0;
  /** Of the page's, the one that is open. */
  tab = 'patches';

  constructor(
    private readonly session: Session,
    private readonly told: PanelTold,
  ) {
    this.patches = new PatchList(session, told);
    this.joints = new JointList(session);
  }

  clear(): void {
    for (const list of [this.minima, this.snapshots, this.facts]) list.replaceChildren();
    this.patches.clear();
    this.joints.clear();
    this.weightsKey = this.minimaKey = '';
    this.ghost = null;
    this.keeping.clear();
    this.differences.replaceChildren();
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
    if (this.tab === 'patches') this.patches.show();
    if (this.tab === 'joints') this.joints.show();
    if (this.tab !== 'more') return;
    this.showMinima();
    this.showSnapshots();
    this.showFacts();
    this.showWeights();
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
            onclick: () => void this.session.editing.edit(edits.choose(rank)),
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
    const take = h(
      'button',
      {
        disabled: !this.session.mayEdit || undefined,
        onclick: () => {
          let number = 1;
          while (names.includes(`state-${number}`) || this.keeping.has(`state-${number}`)) ++number;
          const name = `state-${number}`;
          this.keeping.add(name);
          this.told.onKeep(name);
          void this.session.editing.edit(edits.snapshot(name)).then(() => this.session.notify(`Kept as “${name}”.`));
        },
      },
      'Keep this state',
    );
    // First, so that it stays where it is while the list grows.
    this.snapshots.replaceChildren(
      take,
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
              onclick: () => void this.session.editing.edit(edits.restore(name)),
            },
            'go back to it',
          ),
          h('button', { class: 'small', title: 'What differs between it and now', hidden: !this.session.link.isLive || undefined, onclick: () => void this.compare(name) }, 'compare'),
        ),
      ),
      this.differences,
    );
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
          onchange: () => void this.session.editing.edit(edits.weights({ ...weights, [name]: Number(input.value) })),
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
