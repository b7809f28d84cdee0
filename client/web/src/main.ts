// The page: what is where on it, and which part of it does what.

import { Vector3, type Matrix4 } from 'three';
import { ghostColors } from './bodies';
import { saveAs } from './export';
import { h, icon } from './dom';
import { History } from './history';
import { dropped } from './files';
import { legendStops } from './colors';
import { findLink } from './link';
import { OpenDialog } from './open';
import { matrixOf } from './mesh';
import { Panel } from './panel';
import { Session, type Change } from './session';
import { Stage } from './stage';
import { Timeline } from './timeline';
import { Tools, type Mode } from './tools';
import { View } from './view';
import { edits } from './wire';
import { saidBy } from './words';

const kIcons = {
  patches: 'M12 3v4M12 17v4M3 12h4M17 12h4M12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z',
  fingers: 'M8 13V5a1.5 1.5 0 0 1 3 0v6m0-1V3.5a1.5 1.5 0 0 1 3 0V11m0-5a1.5 1.5 0 0 1 3 0v8c0 4-2 7-5.5 7S7 19 5 15l-1-2.5a1.4 1.4 0 0 1 2.5-1L8 13.500',
  object: 'M12 3l8 4.500v9L12 21l-8-4.500v-9zM12 12l8-4.500M12 12v9M12 12L4 7.500',
  palm: 'M6 21v-5L4 12.500a1.4 1.4 0 0 1 2.500-1L8 13.500V7h9v8c0 3-1 4.500-2 6zM12.500 1v4m-2-2l2-2 2 2M19 11h4m-2-2l2 2-2 2',
  undo: 'M9 7L4 12l5 5M4 12h10a6 6 0 0 1 6 6',
  redo: 'M15 7l5 5-5 5M20 12H10a6 6 0 0 0-6 6',
  frame: 'M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5',
  theme: 'M12 3a9 9 0 1 0 0 18zM12 3a9 9 0 0 1 0 18',
  save: 'M12 4v10m-4-4l4 4 4-4M4 18v2h16v-2',
  panel: 'M4 5h16v14H4zM14 5v14',
};

const session = new Session(findLink());
const root = document.getElementById('page')!;

// === The picture

const canvas = h('canvas', {
  tabIndex: 0,
  role: 'img',
  'aria-label': 'The hand, the object and the contacts on both. Arrow keys move the contact that is chosen, or the object or the palm where these are dragged.',
});
const area = h('div', { class: 'picture' }, canvas);
root.append(area);
const stage = new Stage(canvas);
const view = new View(stage, session);
const hint = h('p', { class: 'hint', role: 'status' });
const tools = new Tools(stage, session, {
  onChoose: (patch) => choose(patch),
  onHover: (patch) => panel.hover(patch),
  onMoved: () => view.place(),
  onGrip: (isHeld) => (isHeld && session.solution !== null ? view.setGhost(session.solution.X_WL.map(matrixOf), 'before') : showGhost()),
  onHint: (text) => {
    hint.textContent = text;
  },
});
view.tools = tools;

function choose(patch: string | null): void {
  panel.choose(patch);
  view.choose(patch);
}

// === Its side

const panel = new Panel(session, {
  onChoose: choose,
  onHover: (patch) => view.choose(patch ?? panelChoice()),
  onGhost: async (of) => {
    ghost = null;
    const revision = session.solution?.revision ?? 0;
    if (typeof of === 'string') {
      const pose = kept.get(of);
      if (pose !== undefined) ghost = { X_WL: pose.X_WL.map(matrixOf), text: of, revision: null };
      else session.notify('It was kept by another page, which has its pose.');
    } else if (of !== null) {
      const X_WL = await view.ghostOf(of).catch((error: unknown) => (session.failed(error), null));
      if (X_WL !== null && revision === session.solution?.revision) ghost = { X_WL, text: `solution ${of + 1}`, revision };
    }
    showGhost();
    return ghost !== null;
  },
  onKeep: (name) => {
    if (session.solution !== null) kept.set(name, session.solution);
  },
  initialOf: (patch) => view.initialOf(patch),
});
/** The pose that was chosen to be seen beside; of another solution for as long as these are ranked. */
let ghost: { X_WL: Matrix4[]; text: string; revision: number | null } | null = null;
function showGhost(): void {
  view.setGhost(ghost?.X_WL ?? null, ghost?.text);
}
const kept = new Map<string, NonNullable<Session['solution']>>();
const panelChoice = () => panel.patches.querySelector<HTMLElement>('.patch.chosen')?.dataset['patch'] ?? null;
const history = new History(session, (past) => {
  view.past = past?.solution ?? null;
  view.update();
});

const timeline = new Timeline(session);

function toggle(text: string, name: 'patches' | 'residuals' | 'depth' | 'map' | 'measured' | 'sites' | 'normals' | 'lost', title: string): HTMLLabelElement {
  const box = h('input', {
    type: 'checkbox',
    checked: view.look[name],
    onchange: () => view.setLook({ [name]: box.checked }),
  });
  return h('label', { class: 'line', title }, box, text);
}

const opacity = h('input', {
  type: 'range',
  min: '0.15',
  max: '1',
  step: '0.05',
  value: String(view.look.opacity),
  'aria-label': 'how solid the hand is drawn',
  oninput: () => view.setLook({ opacity: Number(opacity.value) }),
});
const measuredToggle = toggle('Measured hand', 'measured', 'The joints of the hand that follows this session, as its bridge measures them');
measuredToggle.hidden = true; // until one is heard
const mapToggle = toggle('Contact map', 'map', 'The heat that the touching hand left');
const tabs: [string, string, HTMLElement][] = [
  ['patches', 'Contacts', h('section', {}, panel.patches)],
  ['time', 'Time', h('section', {}, timeline.plots)],
  ['joints', 'Joints', h('section', {}, panel.joints)],
  [
    'more',
    'More',
    h(
      'section',
      {},
      h('h2', {}, 'Shown'),
      toggle('Contacts', 'patches', 'Outlines and dots on both surfaces'),
      toggle('Distances', 'residuals', 'A line from each point on the hand to its partner on the object'),
      toggle('Depth', 'depth', 'Where the hand lies inside the object'),
      toggle('Normals', 'normals', 'Where the surfaces face, at the points that should meet'),
      toggle('Points lost', 'lost', 'Crosses where a point of a contact found no place on the hand'),
      toggle('Sites', 'sites', 'Where contacts are laid on this hand, by name'),
      mapToggle,
      measuredToggle,
      h('label', { class: 'line' }, 'Solid hand', opacity),
      h('h2', {}, 'Poses seen'),
      history.element,
      h('h2', {}, 'Other solutions'),
      panel.minima,
      h('h2', {}, 'Snapshots'),
      panel.snapshots,
      h('h2', {}, 'What counts'),
      panel.weights,
      h('h2', {}, 'This solution'),
      panel.facts,
    ),
  ],
];
const tabList = h('div', { class: 'tabs', role: 'tablist' });
const side = h('aside', { class: 'side', 'aria-label': 'Contacts, joints and more' }, tabList);
for (const [name, title, section] of tabs) {
  section.id = `tab-${name}`;
  section.setAttribute('role', 'tabpanel');
  const tab = h('button', { role: 'tab', id: `to-${name}`, 'aria-controls': section.id, onclick: () => openTab(name) }, title);
  tabList.append(tab);
  side.append(section);
}
function openTab(name: string): void {
  for (const [other, , section] of tabs) {
    section.hidden = other !== name;
    document.getElementById(`to-${other}`)?.setAttribute('aria-selected', String(other === name));
  }
  panel.tab = name;
  panel.showNow();
  history.isSeen = name === 'more';
  history.show();
  timeline.isSeen = name === 'time';
  timeline.draw();
}

// === Its head

const title = h('h1', {}, 'Handgraft');
const verdict = h('span', { class: 'pill' });
const people = h('span', { class: 'people' });
const button = (name: keyof typeof kIcons, text: string, act: () => void) =>
  h('button', { class: 'icon', title: text, 'aria-label': text, onclick: act }, icon(kIcons[name]));
const undo = button('undo', 'Undo (Ctrl+Z)', () => void session.undo());
const redo = button('redo', 'Redo (Ctrl+Y)', () => void session.redo());
const dialog = new OpenDialog(session);
const openButton = h('button', { onclick: () => void dialog.open() }, 'Open…');
const saveMenu = h('details', { class: 'menu' });
const saveButton = h('summary', { title: 'Save', 'aria-label': 'Save', role: 'button', class: 'icon' }, icon(kIcons.save));
saveMenu.append(
  saveButton,
  h(
    'div',
    { class: 'items', role: 'menu' },
    ...(
      [
        ['png', 'Picture (PNG)'],
        ['link', 'Copy the link'],
        ['html', 'Page as one file (HTML)'],
        ['session', 'Session (JSON)'],
        ['json', 'Pose (JSON)'],
        ['csv', 'Table (CSV)'],
        ['glb', 'Scene (glTF)'],
      ] as const
    ).map(([format, text]) => {
      const isHere = format === 'png' || session.link.isLive;
      return h(
        'button',
        {
          role: 'menuitem',
          hidden: !isHere || undefined,
          onclick: () => {
            saveMenu.open = false;
            void saveAs(format, session, stage).catch((error: unknown) => session.failed(error));
          },
        },
        text,
      );
    }),
  ),
);
function closeMenu(): void {
  saveMenu.open = false;
  saveButton.focus();
}
// A press anywhere else closes it.
window.addEventListener('pointerdown', (event) => {
  if (saveMenu.open && !saveMenu.contains(event.target as Node)) saveMenu.open = false;
}, { capture: true });
const head = h(
  'header',
  {},
  title,
  verdict,
  h('span', { class: 'space' }),
  people,
  undo,
  redo,
  openButton,
  saveMenu,
  button('frame', 'Show all (F)', () => void view.frame(true)),
  button('theme', 'Light or dark', () => setTheme(theme() === 'dark' ? 'light' : 'dark')),
  button('panel', 'Show or hide the side', () => root.classList.toggle('wide')),
);

// === What lies over the picture

const modes: [Mode, string, string][] = [
  ['patches', 'Contacts', '1'],
  ['fingers', 'Fingers', '2'],
  ['object', 'Object', '3'],
  ['palm', 'Palm', '4'],
];
const modeButtons = new Map<Mode, HTMLButtonElement>();
const toolbar = h('div', { class: 'modes', role: 'toolbar', 'aria-label': 'What to drag' });
for (const [mode, text, key] of modes) {
  const one = h('button', { title: `Drag ${text.toLowerCase()} (${key})`, 'aria-pressed': 'false', onclick: () => setMode(mode) }, icon(kIcons[mode]), h('span', {}, text));
  modeButtons.set(mode, one);
  toolbar.append(one);
}
function setMode(mode: Mode): void {
  for (const [other, one] of modeButtons) one.setAttribute('aria-pressed', String(other === mode));
  tools.setMode(mode);
  ways.hidden = mode !== 'object' && mode !== 'palm';
  view.update();
}
// What was put somewhere and stays there.
const letGo = h('button', { class: 'held', hidden: true, onclick: () => void session.edit(edits.release('')) });
// Keys do the same; who has none presses these.
const ways = h(
  'div',
  { class: 'ways', hidden: true, role: 'group', 'aria-label': 'What the arrows do' },
  ...(['translate', 'rotate'] as const).map((way) => {
    const one = h('button', { class: 'small', 'aria-pressed': String(way === 'translate'), onclick: () => setWay(way) }, way === 'translate' ? 'Move' : 'Turn');
    one.dataset['way'] = way;
    return one;
  }),
);
function setWay(way: 'translate' | 'rotate'): void {
  for (const one of ways.querySelectorAll('button')) one.setAttribute('aria-pressed', String(one.dataset['way'] === way));
  tools.turnGizmo(way);
}
toolbar.append(ways, letGo);
function showHeld(): void {
  const held = session.motion === null ? session.solution?.held : session.settings?.held; // at times: they have marks
  const links = (held ?? []).map((one) => one.link);
  letGo.hidden = links.length === 0;
  letGo.textContent = `Let go of ${links.length === 1 ? links[0] : `${links.length} held places`}`;
  letGo.title = `Held where they were put: ${links.join(', ')}`;
}
const legend = h(
  'figure',
  { class: 'legend', 'aria-label': 'Colours of the lines: distance between hand and object in millimetres' },
  h('figcaption', {}, 'distance, mm'),
  h('span', { class: 'ramp', style: { '--stops': legendStops.map((stop) => `${stop.css} ${100 * stop.at}%`).join(', ') } }),
  h('span', { class: 'ticks' }, ...legendStops.map((stop) => h('span', {}, String(stop.mm)))),
  h('span', { class: 'key' }, h('i', { class: 'disc' }), 'on the hand', h('i', { class: 'ring' }), 'on the object'),
);
const shells = h('span', { class: 'shells' });
legend.append(shells);
view.onGhosts = () => {
  shells.replaceChildren(
    ...([
      [ghostColors.pose, view.ghostText],
      [ghostColors.measured, view.measuredText],
    ] as const)
      .filter(([, text]) => text !== '')
      .map(([color, text]) => h('span', {}, h('i', { class: 'shell', style: { background: color } }), text)),
  );
};
const banner = h('div', { class: 'banner', role: 'alert', hidden: true });
const empty = h(
  'div',
  { class: 'empty', hidden: true },
  h('h2', {}, 'No session is open'),
  h('p', {}, 'Open one that the server has, choose a hand, an object and contacts for a new one, or drop their files here.'),
  h('button', { class: 'main', onclick: () => void dialog.open() }, 'Open…'),
);
const busy = h('div', { class: 'busy', hidden: true, role: 'status' }, 'Loading…');
const toasts = h('div', { class: 'toasts', role: 'log', 'aria-live': 'polite' });
area.append(toolbar, legend, hint, banner, empty, busy, toasts, timeline.element);
root.prepend(head);
root.append(side);
document.body.append(dialog.element);
openTab('patches');
setMode('patches');

// === Light and dark

function theme(): 'light' | 'dark' {
  return document.documentElement.dataset['theme'] === 'dark' ? 'dark' : 'light';
}
function setTheme(name: 'light' | 'dark'): void {
  document.documentElement.dataset['theme'] = name;
  stage.setTheme(name);
  history.clear();
  history.show();
  timeline.draw();
  try {
    localStorage.setItem('handgraft-theme', name);
  } catch {
    // Of a file, or in private: it is chosen anew next time.
  }
}
function storedTheme(): string | null {
  try {
    return localStorage.getItem('handgraft-theme');
  } catch {
    return null;
  }
}
setTheme((storedTheme() ?? (matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light')) as 'light' | 'dark');

// === What changes

function shown(change: Change): void {
  const state = session.state;
  if (change === 'none') {
    ghost = null;
    view.clear();
    panel.clear();
    choose(null);
  }
  if (change === 'models') {
    view.build();
    mapToggle.hidden = view.object?.hasMap !== true;
    panel.clear();
  }
  if (change === 'grip') return timeline.grip();
  if (change === 'frames') timeline.refresh();
  if (change === 'reach') timeline.showReach();
  if (change === 'motion' || change === 'none' || change === 'settings') timeline.show();
  if (change === 'measured' || change === 'none') {
    view.showMeasured();
    measuredToggle.hidden = session.measured === null;
    if (change === 'measured') return;
  }
  if (change === 'clock') timeline.follow();
  if (change === 'pose') {
    if (ghost !== null && ghost.revision !== null && ghost.revision !== session.solution?.revision) {
      ghost = null; // others are ranked now
      panel.dropGhost();
      showGhost();
    }
    view.update();
    history.show();
  }
  if (change === 'settings') view.update();
  if (change === 'settings' || change === 'reach') panel.showNow();
  else if (change === 'pose' || change === 'models') panel.show();
  const isOfMotion = session.motion !== null;
  if (isOfMotion && !root.classList.contains('of-motion')) {
    openTab('time');
    if (tools.mode === 'object') setMode('patches'); // the motion moves it
    tools.setMode(tools.mode); // it may be edited now
  }

  showHeld();

  // === The head
  const isOpen = state !== null;
  document.title = isOpen ? `${state.hand} grasps ${state.object} – Handgraft` : 'Handgraft';
  title.textContent = isOpen ? `${state.hand} grasps ${state.object}` : 'Handgraft';
  title.title = isOpen ? `session ${session.id}, by ${state.motion || state.contacts}` : '';
  const solution = session.solution;
  const fits = solution?.patches ?? [];
  const reached = fits.filter((fit) => fit.diagnosis.verdict === 'reached').length;
  verdict.hidden = !isOpen || solution === null;
  verdict.textContent = solution?.is_diagnosed ? `${reached} of ${fits.length} reached` : 'solving…';
  verdict.title = solution?.verdict ?? '';
  verdict.dataset['tone'] = !solution?.is_diagnosed ? 'off' : reached === fits.length ? 'good' : 'warn';
  const others = session.pages.filter((one) => one.page !== session.page && one.sessions.includes(session.id));
  const last = state !== null && state.last_edit !== '' && session.editor !== '' ? saidBy(session.editor, state.last_edit) : '';
  people.textContent = [others.length > 0 ? `${others.length + 1} pages here` : '', last].filter((text) => text !== '').join(' · ');
  people.title = others.map((one) => session.nameOf(one.page)).join(', ');
  undo.disabled = !session.mayUndo;
  redo.disabled = !session.mayEdit || (state?.redo_count ?? 0) === 0;
  toolbar.hidden = !session.mayEdit || !isOpen;
  openButton.hidden = !session.link.isLive;
  root.classList.toggle('of-motion', isOfMotion);
  document.getElementById('to-time')!.hidden = !isOfMotion;
  modeButtons.get('object')!.hidden = isOfMotion;
  legend.hidden = !isOpen;
  hint.hidden = !isOpen || isOfMotion;
  empty.hidden = isOpen || session.id !== 0 || !session.isUp;
  busy.hidden = !isOpen || solution !== null;

  // === The wire
  const trouble = !session.link.isLive
    ? ''
    : !session.isUp
      ? 'The connection is gone. This page goes on by itself when it is back.'
      : !session.isHeard
        ? 'The server does not answer. This page goes on by itself when it does.'
        : '';
  banner.hidden = trouble === '';
  banner.textContent = trouble;
  root.classList.toggle('cut-off', trouble !== '');
  if (change === 'link' || change === 'state' || change === 'none') rememberSession();
  if (change === 'state' || change === 'link') hint.textContent = tools.hint();
}

/** The address says which session it is, for reloading and for sharing. */
function rememberSession(): void {
  if (!session.link.isLive) return;
  const address = new URL(location.href);
  if (session.id === 0) address.searchParams.delete('session');
  else address.searchParams.set('session', String(session.id));
  if (address.href !== location.href) window.history.replaceState(null, '', address);
}

session.watch(shown);
session.onNotice((notice) => {
  for (const same of [...toasts.children]) if (same.textContent === notice.text) same.remove();
  const toast = h('p', { class: notice.kind }, notice.text);
  toasts.append(toast);
  while (toasts.children.length > 3) toasts.firstChild?.remove();
  setTimeout(() => toast.remove(), notice.kind === 'wrong' ? 9000 : 4000);
});

// === Files that are dropped

const dropHere = h('div', { class: 'drop', hidden: true }, h('p', {}, 'Drop a hand (its folder or a zip), an object, contacts'));
document.body.append(dropHere);
const isOfFiles = (event: DragEvent) => event.dataTransfer?.types.includes('Files') === true;
let inside = 0; // elements that the pointer has entered and not left
window.addEventListener('dragenter', (event) => {
  if (!isOfFiles(event)) return;
  ++inside;
  dropHere.hidden = !session.mayOpen;
});
window.addEventListener('dragleave', (event) => {
  if (isOfFiles(event) && --inside <= 0) dropHere.hidden = true;
});
window.addEventListener('dragover', (event) => {
  if (!isOfFiles(event)) return;
  event.preventDefault(); // else the browser opens the file instead of the page
});
window.addEventListener('drop', (event) => {
  inside = 0;
  dropHere.hidden = true;
  if (!isOfFiles(event)) return;
  event.preventDefault();
  if (!session.link.isLive) session.notify('This page is a file, without a server: it loads nothing.', 'wrong');
  else if (!session.mayOpen) session.notify('This link is for looking: it loads nothing.', 'wrong');
  else void dialog.take(dropped(event.dataTransfer!));
});

// === Keys

const kStep_m = 0.002;
window.addEventListener('keydown', (event) => {
  const target = event.target as HTMLElement;
  if (target.matches('input:not([type=checkbox]):not([type=range]), select, textarea') || dialog.element.open) return;
  const withControl = event.ctrlKey || event.metaKey;
  const key = event.key.toLowerCase();
  if (withControl && key === 'z') void (event.shiftKey ? session.redo() : session.undo());
  else if (withControl && key === 'y') void session.redo();
  else if (withControl || event.altKey) return;
  else if (/^[1-4]$/.test(key)) {
    const mode = modes[Number(key) - 1]![0];
    if (!modeButtons.get(mode)!.hidden) setMode(mode);
  }
  else if (key === 'f') void view.frame(true);
  else if (key === 'r' || key === 'g') setWay(key === 'r' ? 'rotate' : 'translate');
  else if (key === 'escape' && saveMenu.open) closeMenu();
  else if (key === 'escape') choose(null);
  else if (session.motion !== null && key === ' ' && !target.matches('button, input, select, summary')) timeline.toggle();
  else if (session.motion !== null && (key === ',' || key === '.')) timeline.step(key === ',' ? -1 : 1);
  else if (/^(arrow|page)/.test(key) && target === canvas && (tools.mode === 'object' || tools.mode === 'palm')) tools.step(key, event.shiftKey);
  else if (key.startsWith('arrow') && target === canvas && view.chosen !== null) nudge(key, !event.shiftKey);
  else return;
  event.preventDefault();
});

function nudge(key: string, onHand: boolean): void {
  const x = new Vector3().setFromMatrixColumn(stage.camera.matrixWorld, 0);
  const y = new Vector3().setFromMatrixColumn(stage.camera.matrixWorld, 1);
  const step = key === 'arrowleft' ? x.negate() : key === 'arrowright' ? x : key === 'arrowup' ? y : y.negate();
  tools.nudge(view.chosen!, onHand ? 'hand' : 'object', step.multiplyScalar(kStep_m));
}

// For tests, and for whoever opens the console.
(window as unknown as Record<string, unknown>)['handgraft'] = { session, view, stage, tools, timeline };
view.onFirstPicture = () => {
  (window as unknown as Record<string, unknown>)['handgraftFirstPicture_ms'] = performance.now();
};
session.start(Number(new URLSearchParams(location.search).get('session') ?? 0));
shown('link');
