// A motion and its page, for the tests of both.

import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { browser, handgraft, kWaiting } from './browser.mjs';

const kDemo = fileURLToPath(new URL('../../system/demo/', import.meta.url));

/** A box off a shelf, of 26 frames at 10 a second, and a hand that followed it. */
export async function openMotion(rate_hz = 10) {
  const models = await handgraft('models');
  const name = `pull${rate_hz}`;
  if (!models.includes(name)) {
    await handgraft('motion', 'join', 'box_5', join(kDemo, 'box_4.json'), '--path', join(kDemo, 'pull.csv'), '--rate', String(rate_hz), '--name', name);
  }
  const text = await handgraft('motion', 'solve', '--hand', 'tendon16', '--motion', name, '--keep', '--json');
  return JSON.parse(text).session_id;
}

export async function openMotionPage(address, size = { width: 1100, height: 700 }) {
  const page = await browser.newPage();
  await page.setViewport(size);
  page.on('pageerror', (error) => {
    console.log('page error:', error.stack ?? error.message);
    page.broken = error;
  });
  await page.goto(address);
  await page.waitForFunction(() => globalThis.handgraft?.session.motion && globalThis.handgraft.session.settings && globalThis.handgraft.view.hand, kWaiting);
  return page;
}

export const timeOf = (page) => page.evaluate(() => globalThis.handgraft.timeline.time_s);
export const framesOf = (page) => page.evaluate(() => globalThis.handgraft.session.motion.frames);

/** By a real pointer, at that share of the bars. */
export async function point(page, share) {
  // Asked for at once: bars are drawn anew while frames come.
  const lane = await page.$eval('.bars .lane', (bar) => {
    const { x, y, width, height } = bar.getBoundingClientRect();
    return { x, y, width, height };
  });
  await page.mouse.click(lane.x + 1 + share * (lane.width - 2), lane.y + lane.height / 2);
}
