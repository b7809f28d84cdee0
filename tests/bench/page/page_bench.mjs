// What a person waits for in the page: the first picture in browsers that have just started, and from a dragged root to its pose.
// page_bench.mjs BIN PACKAGES SCRATCH DOMAIN HAND OBJECT CONTACTS [ROUNDS] [SECONDS] [--json]

import { readFileSync } from 'node:fs';
import { kPatience_ms, kWaiting, launch, openSession, rest, sleep, startServer, startView, stopAll } from '../../client/web/browser.mjs';

const words = process.argv.slice(6);
const asJson = words.includes('--json');
const [hand, object, contacts, rounds = '7', seconds = '20'] = words.filter((word) => word !== '--json');
const kMoves = 30; // a second

const sorted = (values) => [...values].sort((a, b) => a - b);
const quantile = (values, at) => sorted(values)[Math.min(values.length - 1, Math.floor(at * values.length))];
const load = () => Number(readFileSync('/proc/loadavg', 'utf8').split(' ')[0]);
const say = (text) => asJson || console.log(text);

/** Milliseconds from the page's load until hand and object are drawn. */
async function firstPicture_ms(address) {
  const browser = await launch();
  try {
    const page = await browser.newPage();
    await page.setViewport({ width: 1280, height: 720 });
    await sleep(500);
    await page.goto(address);
    await page.waitForFunction(() => globalThis.handgraftFirstPicture_ms !== undefined, { polling: 50, timeout: kPatience_ms });
    return await page.evaluate(() => globalThis.handgraftFirstPicture_ms);
  } finally {
    await browser.close();
  }
}

async function heap_MB(page) {
  const devtools = await page.createCDPSession();
  await devtools.send('HeapProfiler.collectGarbage');
  const { JSHeapUsedSize } = await page.metrics();
  await devtools.detach();
  return JSHeapUsedSize / 1e6;
}

/** Once round in two seconds. The moves are the page's own: a browser that draws in software takes a real mouse no faster than it draws. */
function circle(page, x, y) {
  return page.evaluate(
    (centerX, centerY, perSecond) =>
      new Promise((done) => {
        const begun = performance.now();
        let moves = 0;
        const timer = setInterval(() => {
          const turns = (performance.now() - begun) / 2000;
          if (turns >= 1) {
            clearInterval(timer);
            done({ moves, circling_ms: performance.now() - begun });
            return;
          }
          if (performance.now() - begun < (1000 * moves) / perSecond) return;
          ++moves;
          const angle = 2 * Math.PI * turns;
          const at = { clientX: centerX + 7 * Math.sin(angle), clientY: centerY + 3 * (1 - Math.cos(angle)) };
          const event = { ...at, bubbles: true, pointerId: 1, pointerType: 'mouse', isPrimary: true, button: -1, buttons: 1 };
          document.querySelector('canvas').dispatchEvent(new PointerEvent('pointermove', event));
        }, 4);
      }),
    x,
    y,
    kMoves,
  );
}

/** A root of the hand, where most of its neighbourhood is to be seen, drawn about in circles by the mouse. */
async function drag(address, patch) {
  const browser = await launch();
  try {
    const page = await browser.newPage();
    await page.setViewport({ width: 1280, height: 720 });
    await page.goto(address);
    await page.waitForFunction(() => globalThis.handgraft?.view.facts().handles.length > 0, kWaiting);
    await rest(page);
    const { handles } = await page.evaluate(() => globalThis.handgraft.view.facts());
    const roots = handles.filter((one) => one.side === 'hand' && one.kind === 'root');
    const dot = roots.find((one) => one.patch === patch) ?? roots[0];
    const box = await (await page.$('canvas')).boundingBox();
    const [x, y] = [box.x + dot.x, box.y + dot.y];
    const heap = [await heap_MB(page)];
    await page.evaluate(() => (globalThis.handgraft.session.editing.delays_ms.length = 0));
    const begun = Date.now();
    const took = () => (Date.now() - begun) / 1000;
    let moves = 0;
    let dragged_s = 0; // without the time between two drags
    while (took() < Number(seconds)) {
      await page.mouse.move(x, y);
      await page.mouse.down();
      const round = await circle(page, x, y);
      moves += round.moves;
      dragged_s += round.circling_ms / 1000;
      await page.mouse.up();
      if (took() > 120 * heap.length) heap.push(await heap_MB(page));
    }
    await page.mouse.up().catch(() => undefined);
    await rest(page);
    heap.push(await heap_MB(page));
    const delays = await page.evaluate(() => globalThis.handgraft.session.editing.delays_ms);
    return {
      patch: dot.patch,
      moves_per_s: moves / dragged_s,
      edits_per_s: delays.length / dragged_s,
      ms_median: quantile(delays, 0.5),
      ms_p95: quantile(delays, 0.95),
      ms_max: quantile(delays, 1),
      heap_MB: heap,
    };
  } finally {
    await browser.close();
  }
}

await startServer();
try {
  const session = await openSession(hand, object, contacts);
  const { address } = await startView(String(session));
  const pictures_ms = [];
  for (let i = 0; i < Number(rounds); ++i) {
    pictures_ms.push(await firstPicture_ms(address));
    say(`first picture ${pictures_ms.at(-1).toFixed(0)} ms, load ${load()}`);
  }
  say(`first picture: median ${quantile(pictures_ms, 0.5).toFixed(0)} ms, ${quantile(pictures_ms, 0).toFixed(0)} to ${quantile(pictures_ms, 1).toFixed(0)} ms`);
  const dragged = await drag(address, 'index');
  say(
    `root of ${dragged.patch} dragged for ${seconds} s: ${dragged.moves_per_s.toFixed(1)} moves and ${dragged.edits_per_s.toFixed(1)} edits a second, edit to pose ` +
      `median ${dragged.ms_median.toFixed(1)}, p95 ${dragged.ms_p95.toFixed(1)}, most ${dragged.ms_max.toFixed(1)} ms, ` +
      `heap ${dragged.heap_MB.map((one) => one.toFixed(1)).join(', ')} MB, load ${load()}`,
  );
  if (asJson) console.log(JSON.stringify({ first_picture_ms: pictures_ms, drag: dragged, load: load() }));
} finally {
  await stopAll();
}
