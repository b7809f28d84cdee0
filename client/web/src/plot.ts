// How plots look: history and timeline share it.

import type uPlot from 'uplot';

/** An axis in the page's present colours. */
export function axis(label: string, size: number, more: uPlot.Axis = {}): uPlot.Axis {
  const stroke = getComputedStyle(document.documentElement).getPropertyValue('--ink-soft').trim();
  const font = '11px system-ui';
  return { stroke, grid: { stroke: 'rgba(128,128,128,0.2)', width: 1 }, ticks: { show: false }, font, label, labelSize: 16, labelFont: font, size, ...more };
}

export const cursor: uPlot.Cursor = { drag: { x: false, y: false }, points: { size: 5 } };
