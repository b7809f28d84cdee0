// The poses that this page saw: distances over them, a cursor to look back.

import uPlot from 'uplot';
import { patchColor } from './colors';
import { h } from './dom';
import { axis, cursor, values } from './plot';
import { said } from './words';
import type { Past, Session } from './session';

export class History {
  readonly element: HTMLElement;
  isSeen = false;
  private readonly plotArea = h('div', { class: 'plot' });
  private readonly slider: HTMLInputElement;
  private readonly label = h('span', { class: 'note' });
  private readonly play: HTMLButtonElement;
  private plot: uPlot | null = null;
  private names: string[] = [];
  private timer = 0;

  constructor(
    private readonly session: Session,
    private readonly onLook: (past: Past | null) => void,
  ) {
    this.slider = h('input', {
      type: 'range',
      min: '0',
      max: '0',
      step: '1',
      'aria-label': 'the pose to look at',
      oninput: () => this.look(Number(this.slider.value)),
    });
    this.play = h('button', { class: 'small', 'aria-pressed': 'false', onclick: () => this.toggle() }, '▶ play');
    this.element = h('div', { class: 'history' }, this.plotArea, h('div', { class: 'line' }, this.play, this.slider), this.label);
  }

  clear(): void {
    this.plot?.destroy();
    this.plot = null;
    this.names = [];
  }

  show(): void {
    if (!this.isSeen) return;
    const past = this.session.past;
    const atEnd = this.slider.value === this.slider.max;
    this.slider.max = String(Math.max(0, past.length - 1));
    if (atEnd && this.timer === 0) this.slider.value = this.slider.max;
    const names = this.session.solution?.patches.map((fit) => fit.name) ?? [];
    if (this.plot === null || names.join() !== this.names.join()) this.make(names);
    this.plot?.setData([
      past.map((_, index) => index),
      ...names.map((name) => past.map((one) => one.solution.patches.find((fit) => fit.name === name)?.mean_mm ?? null)),
    ] as uPlot.AlignedData);
    this.tell();
  }

  private make(names: string[]): void {
    this.clear();
    this.names = names;
    this.plot = new uPlot(
      {
        width: this.plotArea.clientWidth || 300,
        height: 170,
        legend: { show: false },
        cursor,
        scales: { x: { time: false }, y: values },
        axes: [
          axis('poses seen', 26, { incrs: [1, 2, 5, 10, 20, 50, 100] }),
          axis('mean mm', 34),
        ],
        series: [{}, ...names.map((name, index) => ({ label: name, stroke: patchColor(name, index), width: 1.8 }))],
        hooks: { setCursor: [(plot) => this.hovered(plot.cursor.idx)] },
      },
      [[], ...names.map(() => [])] as uPlot.AlignedData,
      this.plotArea,
    );
    this.plotArea.onclick = () => {
      const index = this.plot?.cursor.idx;
      if (typeof index === 'number') this.look(index);
    };
  }

  private hovered(index: number | null | undefined): void {
    if (typeof index === 'number') this.tell(index);
  }

  private look(index: number): void {
    this.slider.value = String(index);
    const past = this.session.past[index];
    this.onLook(past === undefined || index === this.session.past.length - 1 ? null : past);
    this.tell();
  }

  private tell(index = Number(this.slider.value)): void {
    const past = this.session.past[index];
    this.label.textContent = past === undefined ? '' : `revision ${past.revision}${past.edit === '' ? '' : `: ${said(past.edit)}`}`;
  }

  private toggle(): void {
    const isPlaying = this.timer !== 0;
    clearInterval(this.timer);
    this.timer = 0;
    if (!isPlaying) {
      this.timer = window.setInterval(() => {
        const next = Number(this.slider.value) + 1;
        this.look(next >= this.session.past.length ? 0 : next);
      }, 120);
    } else {
      this.look(this.session.past.length - 1);
    }
    this.play.textContent = isPlaying ? '▶ play' : '■ stop';
    this.play.setAttribute('aria-pressed', String(!isPlaying));
  }
}
