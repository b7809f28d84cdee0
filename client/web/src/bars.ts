// When each patch of a motion is there, and how.

import { patchColor } from './colors';
import { h } from './dom';
import { kIsThere, type Motion } from './motion';

const kSaid = { reached: 'reached', missed: 'not reached', off: 'off' };

type How = keyof typeof kSaid | 'absent';

/** A row a patch: full where it is reached, pale where it is not, an empty frame where it is off. */
export function barsOf(motion: Motion, isOn: (patch: string, time_s: number) => boolean): HTMLElement[] {
  const { frames, description } = motion;
  const all = motion.duration_s || 1;
  return description.patches.map((name, index) => {
    const color = patchColor(name, index);
    const lane = h('div', { class: 'lane' });
    let begin = 0;
    let how: How = 'absent';
    const close = (end: number) => {
      const from = frames[begin]!.time_s;
      const to = (frames[end] ?? frames.at(-1)!).time_s;
      if (how !== 'absent') {
        const title = `${name}: ${kSaid[how]}, ${from.toFixed(2)} to ${to.toFixed(2)} s`;
        lane.append(h('i', { class: how, title, style: { left: `${(100 * from) / all}%`, width: `${(100 * (to - from)) / all}%`, '--color': color } }));
      }
      begin = end;
    };
    frames.forEach((frame, at) => {
      const patch = frame.patches.find((one) => one.patch === index && one.presence >= kIsThere);
      const now: How = patch === undefined ? 'absent' : !isOn(name, frame.time_s) ? 'off' : patch.reached ? 'reached' : 'missed';
      if (now === how) return;
      close(at);
      how = now;
    });
    close(frames.length - 1);
    return h('div', { class: 'presence', title: name }, h('span', { class: 'name' }, name), lane);
  });
}
