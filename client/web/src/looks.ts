// What of a session is drawn: chosen by who looks.

import { h } from './dom';
import type { View } from './view';

type Toggled = 'patches' | 'residuals' | 'depth' | 'map' | 'measured' | 'sites' | 'normals' | 'lost';

/** The choices; two of them only where there is something to see. */
export function looksOf(view: View): { element: HTMLElement; map: HTMLElement; measured: HTMLElement } {
  const toggle = (text: string, name: Toggled, title: string) => {
    const box = h('input', {
      type: 'checkbox',
      checked: view.look[name],
      onchange: () => view.setLook({ [name]: box.checked }),
    });
    return h('label', { class: 'line', title }, box, text);
  };
  const opacity = h('input', {
    type: 'range',
    min: '0.15',
    max: '1',
    step: '0.05',
    value: String(view.look.opacity),
    'aria-label': 'how solid the hand is drawn',
    oninput: () => view.setLook({ opacity: Number(opacity.value) }),
  });
  const measured = toggle('Measured hand', 'measured', 'The joints of the hand that follows this session, as its bridge measures them');
  measured.hidden = true; // until one is heard
  const map = toggle('Contact map', 'map', 'The heat that the touching hand left');
  const element = h(
    'div',
    { class: 'looks' },
    toggle('Contacts', 'patches', 'Outlines and dots on both surfaces'),
    toggle('Distances', 'residuals', 'A line from each point on the hand to its partner on the object'),
    toggle('Depth', 'depth', 'Where the hand lies inside the object'),
    toggle('Normals', 'normals', 'Where the surfaces face, at the points that should meet'),
    toggle('Points lost', 'lost', 'Crosses where a point of a contact found no place on the hand'),
    toggle('Sites', 'sites', 'Where contacts are laid on this hand, by name'),
    map,
    measured,
    h('label', { class: 'line' }, 'Solid hand', opacity),
  );
  return { element, map, measured };
}
