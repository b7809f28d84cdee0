// How plots look: history and timeline share it.

import type uPlot from 'uplot';

/** An axis in the page's present colours. */
export function axis(label: string, size: number, more: uPlot.Axis = {}): uPlot.Axis {
  const stroke = getComputedStyle(document.documentElement).getPropertyValue('--ink-soft').trim();
  const font = '11px system-ui';
  return { stroke, grid: { stroke: 'rgba(128,128,128,0.2)', width: 1 }, ticks: { show: false }, font, label, labelSize: 16, labelFont: font, size, ...more };
}

const kLeastSpan = 1; // mm or degrees: less is drawn flat, not filled with a range that nobody asked for

/** From the least to the most of the values, a little more on both sides. */
export const values: uPlot.Scale = {
  range: (_plot, least: number | null, most: number | null) => {
    if (least === null || most === null) return [0, kLeastSpan];
    const margin = 0.05 * (most - least);
    const low = least >= 0 && least < 0.5 * most + kLeastSpan ? 0 : least - margin;
    return [low, Math.max(most + margin, low + kLeastSpan)];
  },
};

export const cursor: uPlot.Cursor = { drag: { x: false, y: false }, points: { size: 5 } };
