// Viridis (Smith and van der Walt 2015), by seven of its colours.

import { Color } from 'three';

const kColors = ['#440154', '#443983', '#31688e', '#21918c', '#35b779', '#90d743', '#fde725'].map((css) => new Color(css));

/** Of a value in [0, 1]. */
export function viridis(value: number): Color {
  const at = Math.max(0, Math.min(1, value)) * (kColors.length - 1);
  const low = Math.min(kColors.length - 2, Math.floor(at));
  return kColors[low]!.clone().lerp(kColors[low + 1]!, at - low);
}
