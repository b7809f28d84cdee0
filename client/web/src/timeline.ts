// Time: play, scrub, loop; when each patch is there and reached; distances, joints and limits over time.

import uPlot from 'uplot';
import { barsOf } from './bars';
import { patchColor } from './colors';
import { h } from './dom';
import type { Motion } from './motion';
import { axis, cursor, values } from './plot';
import type { Session } from './session';
import type { FramePatch } from './wire';
import { said } from './words';

const kSpeeds = [0.1, 0.25, 0.5, 1, 2];
const kStep_s = 1 / 30; // of the arrow keys
const kJointColors = 10;
const kScrub_ms = 60; // rest before others are told
const kEcho_ms = 300; // in which one's own setting comes back

type Plotted = 'distances' | 'angles' | 'joints' | 'depth';

const kPlots: Record<Plotted, { title: string; unit: string }> = {
  distances: { title: 'Distances', unit: 'mean mm' },
  angles: { title: 'Angles', unit: 'degrees' },
  joints: { title: 'Joints', unit: 'rad, m' },
  depth: { title: 'Depth', unit: 'deepest mm' },
};

export class Timeline {
  /** Below the picture. */
  readonly element: HTMLElement;
  /** On the side. */
  readonly plots: HTMLElement;
  isSeen = false;
  private readonly slider: HTMLInputElement;
  private readonly playButton: HTMLButtonElement;
  private readonly loopBox: HTMLInputElement;
  private readonly speed: HTMLSelectElement;
  private readonly clock = h('output', { class: 'clock' });
  private readonly bars = h('div', { class: 'bars', 'aria-hidden': 'true' });
  private readonly cursor = h('div', { class: 'cursor' });
  private readonly band = h('div', { class: 'band', 'aria-hidden': 'true' });
  private readonly marks = h('div', { class: 'marks', role: 'list', 'aria-label': 'Edits at times' });
  private readonly reach: HTMLElement;
  private readonly scope: HTMLSelectElement;
  private readonly falloff: HTMLInputElement;
  private readonly list = h('div', { class: 'list timed', role: 'list', 'aria-label': 'Edits at times, one by one' });
  private marksKey = '';
  private readonly choice: HTMLSelectElement;
  private readonly plotArea = h('div', { class: 'plot' });
  private readonly limits = h('p', { class: 'note' });
  private plot: uPlot | null = null;
  private motion: Motion | null = null;
  private last_ms = 0;
  private request = 0;
  private shared_ms = -1e9;
  private scrubTimer = 0;
  time_s = 0;

  constructor(private readonly session: Session) {
    this.slider = h('input', {
      type: 'range',
      min: '0',
      max: '1',
      step: 'any',
      'aria-label': 'time in the motion, seconds',
      oninput: () => {
        this.scrub(Number(this.slider.value));
      },
    });
    this.playButton = h('button', { class: 'small play', 'aria-pressed': 'false', title: 'Play or pause (Space)', onclick: () => this.toggle() }, '▶ play');
    this.loopBox = h('input', { type: 'checkbox', checked: true, onchange: () => this.share('loop', this.loopBox.checked ? 1 : 0) });
    this.speed = h(
      'select',
      { 'aria-label': 'speed', onchange: () => this.share('speed', Number(this.speed.value)) },
      ...kSpeeds.map((speed) => h('option', { value: String(speed), selected: speed === 1 }, `${speed} ×`)),
    );
    this.scope = h(
      'select',
      { 'aria-label': 'what edits hold for', onchange: () => this.tellReach() },
      h('option', { value: 'moment' }, 'about this moment'),
      h('option', { value: 'all' }, 'all of the motion'),
    );
    this.falloff = h('input', {
      type: 'number',
      min: '0',
      max: '1000000',
      step: '0.05',
      value: String(session.reach_s),
      'aria-label': 'how far edits reach to both sides, seconds',
      oninput: () => this.tellReach(),
    });
    this.reach = h('div', { class: 'line reach' }, h('label', { class: 'line' }, 'Edits hold', this.scope), h('label', { class: 'line seconds' }, '±', this.falloff, 's'));
    this.element = h(
      'section',
      { class: 'timeline', 'aria-label': 'Time', hidden: true },
      this.reach,
      h('div', { class: 'line' }, this.playButton, this.slider, this.clock, this.speed, h('label', { class: 'line' }, this.loopBox, 'loop')),
      h('div', { class: 'tracks' }, this.marks, this.bars, this.band, this.cursor),
    );
    this.bars.onpointerdown = (event) => this.pointed(event);
    this.bars.onpointermove = (event) => {
      if (event.buttons !== 0) this.pointed(event);
    };
    this.choice = h(
      'select',
      { 'aria-label': 'what is plotted', onchange: () => this.draw() },
      ...Object.entries(kPlots).map(([name, { title }]) => h('option', { value: name }, title)),
    );
    // The picture ends above it.
    new ResizeObserver(() => {
      this.element.parentElement?.style.setProperty('--below', this.element.hidden ? '0px' : `${this.element.offsetHeight + 12}px`);
    }).observe(this.element);
    this.plots = h('div', { class: 'history' }, h('label', { class: 'line' }, 'Over time', this.choice), this.plotArea, this.limits, h('h2', {}, 'Edits at times'), this.list);
  }

  get isPlaying(): boolean {
    return this.request !== 0;
  }

  /** The session's motion, or none. */
  show(): void {
    const motion = this.session.motion;
    this.showMarks();
    if (motion === this.motion) return;
    this.pause();
    this.motion = motion;
    this.element.hidden = motion === null;
    this.clear();
    if (motion === null) return;
    this.slider.max = String(motion.duration_s);
    this.fillBars(motion);
    this.draw();
    this.seek(Math.min(this.time_s, motion.duration_s));
    this.showReach();
  }

  /** Frames were solved anew. */
  refresh(): void {
    const motion = this.motion;
    if (motion === null) return;
    this.fillBars(motion);
    if (this.isSeen && this.plot !== null) {
      const { series } = this.seriesOf(motion, this.choice.value as Plotted);
      this.plot.setData([motion.frames.map((frame) => frame.time_s), ...series] as uPlot.AlignedData);
    }
  }

  /** A drag begins: it is at one time. */
  grip(): void {
    if (!this.isPlaying) return;
    this.pause();
    this.share('pause');
  }

  // === How far edits reach

  private tellReach(): void {
    const seconds = Number(this.falloff.value);
    const isAll = this.scope.value === 'all';
    if (!isAll && !(seconds >= 0 && seconds <= 1e6)) return; // not finished typing
    this.session.reach(isAll ? null : seconds);
  }

  /** As a band over the bars. */
  showReach(): void {
    const { motion, session } = this;
    if (motion === null) return;
    const { reach_s } = session;
    this.reach.hidden = !session.mayEdit;
    this.falloff.parentElement!.hidden = reach_s === null;
    this.band.hidden = !session.mayEdit;
    const all = motion.duration_s || 1;
    const from = reach_s === null ? 0 : Math.max(0, this.time_s - reach_s) / all;
    const to = reach_s === null ? 1 : Math.min(all, this.time_s + reach_s) / all;
    this.band.classList.toggle('fading', reach_s !== null);
    this.band.style.setProperty('--from', String(from));
    this.band.style.setProperty('--to', String(to));
    this.band.style.setProperty('--peak', `${(100 * (this.time_s / all - from)) / Math.max(1e-6, to - from)}%`);
  }

  // === Edits at times

  /** A mark each: it leads there, and Delete takes it back. */
  showMarks(): void {
    const { motion, session } = this;
    const timed = motion === null ? [] : (session.settings?.timed ?? []);
    const key = JSON.stringify([timed, session.mayEdit, motion?.duration_s, session.settings?.patches.map((patch) => patch.enabled)]);
    if (key === this.marksKey) return;
    this.marksKey = key;
    if (motion !== null && motion === this.motion) this.fillBars(motion); // switches, too
    const all = motion?.duration_s || 1;
    const held = (of: (typeof timed)[number]) => (of.falloff_s >= all ? 'all of it' : of.falloff_s > 0 ? `± ${Number(of.falloff_s.toPrecision(3))} s` : 'that frame');
    const focused = this.marks.contains(document.activeElement);
    this.marks.hidden = timed.length === 0;
    this.marks.replaceChildren(
      ...timed.map((one, index) =>
        h(
          'button',
          {
            class: 'mark',
            role: 'listitem',
            style: { '--at': String(one.time_s / all) },
            title: `${said(one.text)} at ${one.time_s.toFixed(2)} s, ${held(one)}; Delete takes it back`,
            'aria-label': `${said(one.text)} at ${one.time_s.toFixed(2)} s, ${held(one)}`,
            onclick: () => this.goTo(one.time_s),
            onkeydown: (event: KeyboardEvent) => {
              if (event.key !== 'Delete' && event.key !== 'Backspace') return;
              event.preventDefault();
              event.stopPropagation();
              void session.editing.takeBack(index);
            },
          },
        ),
      ),
    );
    if (focused) (this.marks.firstElementChild as HTMLElement | null)?.focus();
    this.list.replaceChildren(
      ...timed.map((one, index) =>
        h(
          'div',
          { class: 'line', role: 'listitem' },
          h('button', { class: 'choice wide', title: 'Go there', onclick: () => this.goTo(one.time_s) }, h('span', {}, said(one.text)), h('span', { class: 'note' }, `${one.time_s.toFixed(2)} s, ${held(one)}`)),
          h('button', { class: 'small', disabled: !session.mayEdit || undefined, 'aria-label': `take back: ${said(one.text)} at ${one.time_s.toFixed(2)} s`, onclick: () => void session.editing.takeBack(index) }, 'take back'),
        ),
      ),
    );
    if (timed.length === 0) this.list.append(h('p', { class: 'note' }, 'None yet: what is edited while a moment is shown holds about it.'));
  }

  private goTo(time_s: number): void {
    this.scrub(time_s);
  }

  private clear(): void {
    this.plot?.destroy();
    this.plot = null;
  }

  toggle(): void {
    if (this.motion === null) return;
    if (this.isPlaying) {
      this.pause();
      this.share('pause');
      return;
    }
    if (this.time_s >= this.motion.duration_s) this.time_s = 0;
    this.play();
    this.share('loop', this.loopBox.checked ? 1 : 0);
    this.share('speed', Number(this.speed.value));
    this.share('seek', this.time_s);
    this.share('play');
  }

  private play(): void {
    this.last_ms = performance.now();
    this.request = requestAnimationFrame((now) => this.tick(now));
    this.tellPlaying();
  }

  /** Somebody else set the clock that all who watch share. */
  follow(): void {
    const shared = this.session.clock;
    // What this page set comes back, too.
    if (shared === null || this.motion === null || performance.now() - this.shared_ms < kEcho_ms) return;
    const { clock, at_ms } = shared;
    const since_s = clock.playing ? (clock.speed * (performance.now() - at_ms)) / 1e3 : 0;
    const time_s = clock.time_s + since_s;
    this.loopBox.checked = clock.looping;
    if (kSpeeds.includes(clock.speed)) this.speed.value = String(clock.speed);
    if (this.isPlaying) this.pause();
    const duration = this.motion.duration_s;
    this.seek(clock.looping && duration > 0 ? time_s % duration : time_s);
    if (clock.playing && (clock.looping || time_s < duration)) this.play();
  }

  private share(action: 'play' | 'pause' | 'seek' | 'speed' | 'loop', value = 0): void {
    this.shared_ms = performance.now();
    this.session.setClock(action, value);
  }

  /** Stops there; others are told where, but not of each step on the way. */
  private scrub(time_s: number): void {
    if (this.isPlaying) this.share('pause');
    this.pause();
    this.seek(time_s);
    clearTimeout(this.scrubTimer);
    this.scrubTimer = window.setTimeout(() => this.share('seek', this.time_s), kScrub_ms);
  }

  pause(): void {
    cancelAnimationFrame(this.request);
    this.request = 0;
    this.tellPlaying();
  }

  step(count: number): void {
    this.scrub(this.time_s + count * kStep_s);
  }

  seek(time_s: number): void {
    const motion = this.motion;
    if (motion === null) return;
    this.time_s = Math.min(motion.duration_s, Math.max(0, time_s));
    this.slider.value = String(this.time_s);
    this.slider.setAttribute('aria-valuetext', `${this.time_s.toFixed(2)} s`);
    this.clock.textContent = `${this.time_s.toFixed(2)} / ${motion.duration_s.toFixed(2)} s`;
    const share = motion.duration_s > 0 ? this.time_s / motion.duration_s : 0;
    this.cursor.style.setProperty('--at', String(share));
    this.session.showAt(this.time_s);
    this.showReach();
    if (this.isSeen) this.plot?.redraw(false, false);
    const limits = motion.frames[motion.indexAt(this.time_s)]!.joints_at_limit;
    this.limits.textContent = limits.length === 0 ? '' : `at their limits: ${limits.map((one) => `${one.joint} (${one.side})`).join(', ')}`;
  }

  /** Of what is plotted: for who looks at the side. */
  draw(): void {
    const motion = this.motion;
    this.clear();
    if (motion === null || !this.isSeen) return;
    const kind = this.choice.value as Plotted;
    const { series, labels, colors } = this.seriesOf(motion, kind);
    this.plot = new uPlot(
      {
        width: this.plotArea.clientWidth || 300,
        height: 220,
        legend: { show: true },
        cursor,
        scales: { x: { time: false }, y: values },
        axes: [
          axis('s', 26),
          axis(kPlots[kind].unit, 38),
        ],
        series: [
          { label: 's', value: (_, time) => (time === null ? '' : time.toFixed(2)) },
          ...labels.map((label, index) => ({ label, stroke: colors[index]!, width: 1.6, value: (_: uPlot, y: number | null) => (y === null ? '–' : y.toFixed(2)) })),
        ],
        hooks: { draw: [(plot) => this.drawTime(plot)] },
      },
      [motion.frames.map((frame) => frame.time_s), ...series] as uPlot.AlignedData,
      this.plotArea,
    );
    this.plotArea.onclick = () => {
      const index = this.plot?.cursor.idx;
      if (typeof index !== 'number') return;
      this.scrub(motion.frames[index]!.time_s);
    };
  }

  private seriesOf(motion: Motion, kind: Plotted): { series: (number | null)[][]; labels: string[]; colors: string[] } {
    const names = motion.description.patches;
    const ofPatches = (value: (patch: FramePatch) => number) => ({
      series: names.map((_, index) =>
        motion.frames.map((frame) => {
          const patch = frame.patches.find((one) => one.patch === index);
          return patch === undefined ? null : value(patch);
        }),
      ),
      labels: names,
      colors: names.map((name, index) => patchColor(name, index)),
    });
    switch (kind) {
      case 'distances':
        return ofPatches((patch) => patch.mean_mm);
      case 'angles':
        return ofPatches((patch) => patch.normal_deg);
      case 'depth':
        return {
          series: [
            motion.frames.map((frame) => 1e3 * frame.max_depth_m),
            motion.frames.map((frame) => 1e3 * frame.self_depth_m),
          ],
          labels: ['in the object', 'in itself'],
          colors: [patchColor('', 0), patchColor('', 1)],
        };
      case 'joints': {
        const joints = this.session.state?.joint_names ?? [];
        return {
          series: joints.map((_, joint) => motion.frames.map((frame) => frame.joint_positions[joint] ?? null)),
          labels: joints,
          colors: joints.map((_, joint) => patchColor('', joint % kJointColors)),
        };
      }
    }
  }

  /** The time that is shown, as a line over the plot. */
  private drawTime(plot: uPlot): void {
    const x = Math.round(plot.valToPos(this.time_s, 'x', true));
    const { top, height } = plot.bbox;
    plot.ctx.save();
    plot.ctx.strokeStyle = '#888888';
    plot.ctx.lineWidth = devicePixelRatio;
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }

  private fillBars(motion: Motion): void {
    this.bars.replaceChildren(...barsOf(motion, (patch, time_s) => this.session.isOn(patch, time_s)));
  }

  private pointed(event: PointerEvent): void {
    const lane = this.bars.querySelector('.lane')?.getBoundingClientRect();
    if (lane === undefined || this.motion === null) return;
    this.scrub(((event.clientX - lane.left) / lane.width) * this.motion.duration_s);
  }

  private tick(now: number): void {
    if (this.motion === null || this.request === 0) return;
    const duration = this.motion.duration_s;
    let next = this.time_s + (Math.max(0, now - this.last_ms) / 1e3) * Number(this.speed.value);
    this.last_ms = now;
    if (next >= duration) {
      if (!this.loopBox.checked || duration <= 0) {
        this.seek(duration);
        this.pause();
        return;
      }
      next %= duration;
    }
    this.seek(next);
    this.request = requestAnimationFrame((later) => this.tick(later));
  }

  private tellPlaying(): void {
    this.playButton.textContent = this.isPlaying ? '❚❚ pause' : '▶ play';
    this.playButton.setAttribute('aria-pressed', String(this.isPlaying));
  }
}
