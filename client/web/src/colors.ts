// Colours that colour-blind people tell apart (Okabe and Ito's), and the scale of distances.

import { Color } from 'three';

const kByDigit: Record<string, string> = {
  thumb: '#d55e00',
  index: '#0072b2',
  middle: '#009e73',
  ring: '#cc79a7',
  little: '#d6aa00',
  palm: '#7b61c9',
};
const kOthers = ['#b8860b', '#8c6d4f', '#4f7d8c', '#b0417a', '#6a8f2a', '#e69f00'];

const kSegmentStep = 0.33;
const kNumberStep = 0.11; // three patches before the next segment's shade

/** Darker below 0, paler above. */
function shaded(color: string, share: number): string {
  const end = share < 0 ? 0 : 255;
  const parts = [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));
  return `#${parts.map((part) => Math.round(part + (end - part) * Math.abs(share)).toString(16).padStart(2, '0')).join('')}`;
}

/** Its finger's; the proximal patch is darker, the distal one paler, as in client/present/picture_parts.cpp. */
export function patchColor(name: string, index: number): string {
  const [digit = '', ...rest] = name.split('_');
  const place = Number(/^f(\d+)$/.exec(digit)?.[1] ?? 0); // fingers without a name are f1, f2...
  const own = kByDigit[digit] ?? (place > 0 ? kOthers[(place - 1) % kOthers.length]! : undefined);
  if (own === undefined) {
    const round = Math.floor(index / kOthers.length) % 3;
    return shaded(kOthers[index % kOthers.length]!, [0, -kSegmentStep, kSegmentStep][round]!);
  }
  const segment = rest[0] === 'proximal' ? -kSegmentStep : rest[0] === 'distal' ? kSegmentStep : 0;
  const number = /^\d+$/.test(rest.at(-1) ?? '') ? Number(rest.at(-1)) : 1;
  return shaded(own, Math.min(segment + kNumberStep * (Math.max(number, 1) - 1), 0.7));
}

/** What is written on its dots: "T", "I", "M"; the shortest beginning that no other shares, or a number. */
export function initialsOf(names: string[]): Map<string, string> {
  const initials = new Map<string, string>();
  names.forEach((name, index) => {
    const letter = name.charAt(0).toUpperCase();
    const isShared = names.some((other) => other !== name && other.charAt(0).toUpperCase() === letter);
    initials.set(name, isShared ? String(index + 1) : letter);
  });
  return initials;
}

// Blue, sand, orange, dark red: in order of lightness, too.
const kStops: [number, Color][] = [
  [0, new Color('#2c7fb8')],
  [2, new Color('#7fb8c9')],
  [5, new Color('#f0b429')],
  [10, new Color('#c8370b')],
  [20, new Color('#7a0f1f')],
];
export const kLongest_mm = 20;

export function distanceColor(mm: number): Color {
  for (let i = 1; i < kStops.length; ++i) {
    const [high, color] = kStops[i]!;
    const [low, before] = kStops[i - 1]!;
    if (mm <= high) return before.clone().lerp(color, Math.max(0, (mm - low) / (high - low)));
  }
  return kStops.at(-1)![1].clone();
}

/** The stops as a legend draws them: a colour, where it is (0 to 1), and its number. */
export const legendStops = kStops.map(([mm, color], index) => ({
  css: `#${color.getHexString()}`,
  at: index / (kStops.length - 1),
  mm,
}));

export function depthColor(depth_m: number): Color {
  return new Color('#ffd9e6').lerp(new Color('#a3004f'), Math.min(1, depth_m / 0.006));
}
