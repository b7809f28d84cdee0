// The page: what is where on it, and which part of it does what.

import { Vector3, type Matrix4 } from 'three';
import { ghostColors } from './bodies';
import { acceptDrops } from './drop';
import { h, icon } from './dom';
import { Head } from './head';
import { kIcons } from './icons';
import { looksOf } from './looks';
import { History } from './history';
import { legendStops } from './colors';
import { findLink } from './link';
import { OpenDialog } from './open';
import { matrixOf } from './mesh';
import { Panel } from './panel';
import { samples } from './samples';
import { Session, type Change } from './session';
import { Stage } from './stage';
import { keepTheme, theme, type Theme } from './theme';
import { Timeline } from './timeline';
import { Told } from './told';
import { Tools, type Mode } from './tools';
import { View } from './view';
import { edits } from './wire';

const session = new Session(findLink());
const root = document.getElementById('page')!;

// === The picture

const stage = new Stage(() =>
  h('canvas', {
    tabIndex: 0,
    role: 'img',
    'aria-label': 'The hand, the object and the contacts on both. Arrow keys move the contact that is chosen, or the object or the palm where these are dragged.',
  }),
);
const { canvas } = stage;
const area = h('div', { class: 'picture' }, canvas);
root.append(area);
const view = new View(stage, session);
stage.warm(samples());
const hint = h('p', { class: 'hint', role: 'status' });
const tools = new Tools(stage, session, {
  onChoose: (patch) => choose(patch),
  onHover: (patch) => panel.patches.hover(patch),
  onMoved: () => view.place(),
  onGrip: (isHeld) => (isHeld && session.solution !== null ? view.setGhost(session.solution.X_WL.map(matrixOf), 'before') : showGhost()),
  onHint: (text) => {
    hint.textContent = text;
  },
});
view.tools = tools;

function choose(patch: string | null): void {
  panel.patches.choose(patch);
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
const panelChoice = () => panel.patches.element.querySelector<HTMLElement>('.patch.chosen')?.dataset['patch'] ?? null;
const history = new History(session, (past) => {
  view.past = past?.solution ?? null;
  view.update();
});

const timeline = new Timeline(session);

const looks = looksOf(view);
const tabs: [string, string, HTMLElement][] = [
  ['patches', 'Contacts', h('section', {}, panel.patches.element)],
  ['time', 'Time', h('section', {}, timeline.plots)],
  ['joints', 'Joints', h('section', {}, panel.joints.element)],
  [
    'more',
    'More',
    h(
      'section',
      {},
      h('h2', {}, 'Shown'),
      looks.element,
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
const told = new Told(session);
side.append(told.element);
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

const dialog = new OpenDialog(session);
const head = new Head(session, stage, {
  onOpen: () => void dialog.open(),
  onFrame: () => void view.frame(true),
  onTheme: () => setTheme(theme() === 'dark' ? 'light' : 'dark'),
  onSide: () => root.classList.toggle('wide'),
});

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
const letGo = h('button', { class: 'held', hidden: true, onclick: () => void session.editing.edit(edits.release('')) });
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
root.prepend(head.element);
root.append(side);
document.body.append(dialog.element);
openTab('patches');
setMode('patches');

// === Light and dark

function setTheme(name: Theme): void {
  keepTheme(name);
  stage.setTheme(name);
  history.clear();
  history.show();
  timeline.draw();
}
setTheme(theme());

// === What changes

function shown(change: Change): void {
  const state = session.state;
  if (change === 'none') {
    if (session.id === 0) {
      stage.release();
      root.classList.remove('opening');
    }
    ghost = null;
    view.clear();
    panel.clear();
    choose(null);
  }
  if (change === 'models') {
    view.build();
    looks.map.hidden = view.object?.hasMap !== true;
    panel.clear();
  }
  if (change === 'grip') return timeline.grip();
  if (change === 'frames') timeline.refresh();
  if (change === 'reach') timeline.showReach();
  if (change === 'motion' || change === 'none' || change === 'settings') timeline.show();
  if (change === 'measured' || change === 'none') {
    view.showMeasured();
    looks.measured.hidden = session.measured === null;
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

  head.show();
  told.show();
  const isOpen = state !== null;
  toolbar.hidden = !session.mayEdit || !isOpen;
  root.classList.toggle('of-motion', isOfMotion);
  document.getElementById('to-time')!.hidden = !isOfMotion;
  modeButtons.get('object')!.hidden = isOfMotion;
  legend.hidden = !isOpen;
  hint.hidden = !isOpen || isOfMotion;
  empty.hidden = isOpen || session.id !== 0 || !session.isUp;
  busy.hidden = !isOpen || session.solution !== null;

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

acceptDrops(session, dialog);

// === Keys

const kStep_m = 0.002;
window.addEventListener('keydown', (event) => {
  const target = event.target as HTMLElement;
  if (target.matches('input:not([type=checkbox]):not([type=range]), select, textarea') || dialog.element.open) return;
  const withControl = event.ctrlKey || event.metaKey;
  const key = event.key.toLowerCase();
  if (withControl && key === 'z') event.shiftKey ? session.editing.redo() : session.editing.undo();
  else if (withControl && key === 'y') session.editing.redo();
  else if (withControl || event.altKey) return;
  else if (/^[1-4]$/.test(key)) {
    const mode = modes[Number(key) - 1]![0];
    if (!modeButtons.get(mode)!.hidden) setMode(mode);
  }
  else if (key === 'f') void view.frame(true);
  else if (key === 'r' || key === 'g') setWay(key === 'r' ? 'rotate' : 'translate');
  else if (key === 'escape' && head.isMenuOpen) head.closeMenu();
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
// The picture first: what is around it would keep the graphics card from it for as long again.
const kOpening_ms = 1200;
const asked = Number(new URLSearchParams(location.search).get('session') ?? 0);
const opened = () => root.classList.remove('opening');
root.classList.toggle('opening', asked !== 0 || !session.link.isLive);
setTimeout(opened, kOpening_ms);
view.onFirstPicture = () => {
  (window as unknown as Record<string, unknown>)['handgraftFirstPicture_ms'] = performance.now();
  requestAnimationFrame(opened);
};
session.start(asked);
shown('link');
