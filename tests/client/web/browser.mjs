// What the tests of the page stand on: the programs, a real browser, and how tests are run. As page_test.mjs: BIN PACKAGES PICTURES DOMAIN [NAME].

import assert from 'node:assert/strict';
import { execFile, spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, statSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { promisify } from 'node:util';

export const [bin, packages, pictures, domain, only] = process.argv.slice(2);
const chromium = ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find(existsSync);
const driver = join(packages, 'node_modules/puppeteer-core');
if (chromium === undefined || !existsSync(driver)) {
  console.log(`skipped: ${chromium === undefined ? 'chromium' : 'puppeteer-core'} is not installed`);
  process.exit(77);
}
const puppeteer = createRequire(resolve(packages, 'package.json'))('puppeteer-core');
export const run = promisify(execFile);
export const kPatience_ms = 60000;
// By the clock, not by frames: a page in the background draws none.
export const kWaiting = { timeout: kPatience_ms, polling: 100 };
export const downloads = mkdtempSync(join(tmpdir(), 'handgraft_page_'));
mkdirSync(pictures, { recursive: true });

// === The programs

const children = new Set();

export function start(name, ...words) {
  const child = spawn(join(bin, name), words, { stdio: ['ignore', 'pipe', 'inherit'] });
  children.add(child);
  child.on('exit', () => children.delete(child));
  return child;
}

export async function stop(child, signal = 'SIGTERM') {
  if (!children.has(child)) return;
  const gone = new Promise((resolve) => child.on('exit', resolve));
  child.kill(signal);
  await gone;
}

export async function handgraft(...words) {
  const { stdout } = await run(join(bin, 'handgraft'), [...words, '--domain', domain], { maxBuffer: 1 << 26 });
  return stdout;
}

/** What a person at the prompt would type. */
export async function typed(session, text) {
  const prompt = spawn(join(bin, 'handgraft'), ['edit', String(session), '--domain', domain, '--json'], { stdio: ['pipe', 'ignore', 'inherit'] });
  prompt.stdin.end(text);
  await new Promise((resolve) => prompt.on('exit', resolve));
}

/** Of a secured domain: its identity. */
export const ofServer = [];

export async function startServer() {
  const server = start('handgraft-server', '--domain', domain, '--log-level', 'warning', ...ofServer);
  for (let i = 0; i < 100; ++i) {
    try {
      await handgraft('doctor');
      return server;
    } catch {
      await sleep(200);
    }
  }
  throw new Error('the server does not answer');
}

/** `handgraft view`, and where it serves. */
export async function startView(...words) {
  const view = start('handgraft', 'view', '--domain', domain, '--no-browser', '--json', ...words);
  let text = '';
  const line = await new Promise((resolve, reject) => {
    view.stdout.on('data', (chunk) => {
      text += chunk;
      if (text.includes('\n')) resolve(text.split('\n')[0]);
    });
    view.on('exit', (code) => reject(new Error(`view ended with ${code}`)));
  });
  return { process: view, ...JSON.parse(line) };
}

export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// === Pages

export let browser;

/** A browser that has just started. */
export function launch() {
  return puppeteer.launch({
    executablePath: chromium,
    headless: true,
    // Drawn in software: no test machine has to have a graphics card. Without a sandbox, since root may run this.
    args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-dev-shm-usage'],
  });
}

export async function openPage(address, { width = 900, height = 560, touch = false } = {}) {
  const page = await browser.newPage();
  await page.setViewport({ width, height, hasTouch: touch });
  page.on('pageerror', (error) => {
    console.log('page error:', error.stack ?? error.message);
    page.broken = error;
  });
  page.on('console', (message) => {
    if (message.type() === 'error' && !/WebSocket|ERR_CONNECTION/.test(message.text())) {
      console.log('console:', message.text());
      page.broken = new Error(message.text());
    }
  });
  await page.goto(address);
  await page.waitForFunction(
    () => globalThis.handgraft?.session.settings && globalThis.handgraft.view.facts().handles.length > 0,
    kWaiting,
  );
  return page;
}

export const factsOf = (page) => page.evaluate(() => globalThis.handgraft.view.facts());
export const settingsOf = (page) => page.evaluate(() => globalThis.handgraft.session.settings);

/** Waits until nothing is on its way any more: the server's state rests, and the page has it. */
export async function rest(page) {
  await page.waitForFunction(
    () => {
      const { session, tools } = globalThis.handgraft;
      const { state, solution, settings } = session;
      return (
        !tools.isBusy && session.editing.underWay === 0 && state?.phase === 'ready' && solution?.is_diagnosed &&
        solution.revision === state.revision && settings?.state.revision === state.revision
      );
    },
    kWaiting,
  );
}

/** Waits until the page says so: what it says of others comes after their pose. */
export async function waitText(page, selector, pattern) {
  await page.waitForFunction(
    (at, source) => new RegExp(source).test(document.querySelector(at)?.textContent ?? ''),
    kWaiting,
    selector,
    pattern.source,
  );
}

export async function waitRevision(page, revision) {
  await page.waitForFunction((least) => globalThis.handgraft.session.state.revision >= least, kWaiting, revision);
  await rest(page);
}

/** Waits until the picture is drawn anew, and does not move any more. */
export async function still(page) {
  let { frames } = await factsOf(page);
  await page.evaluate(() => globalThis.handgraft.stage.redraw());
  await page.waitForFunction((before) => globalThis.handgraft.stage.frames > before, kWaiting, frames);
  for (let last = -1; last !== frames; ) {
    last = frames;
    await sleep(150);
    ({ frames } = await factsOf(page));
  }
}

/** Where a dot is in the window. */
export async function dotOf(page, patch, side, kind = 'root') {
  await still(page);
  const { handles } = await factsOf(page);
  const found = handles.find((one) => one.patch === patch && one.side === side && one.kind === kind);
  assert.ok(found, `there is a ${kind} of ${patch} on the ${side}`);
  const box = await (await page.$('canvas')).boundingBox();
  return { ...found, x: box.x + found.x, y: box.y + found.y };
}

export async function dragBy(page, from, dx, dy, steps = 6) {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= steps; ++i) {
    await page.mouse.move(from.x + (dx * i) / steps, from.y + (dy * i) / steps);
    await sleep(20);
  }
  await page.mouse.up();
}

export const distance = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
export const picture = (page, name) => page.screenshot({ path: join(pictures, `${name}.png`) });

/** What the server has, asked by another program. */
export async function serverPose(session) {
  const file = join(downloads, 'pose.json');
  await handgraft('export', String(session), '--format', 'json', '--out', file);
  return JSON.parse(readFileSync(file, 'utf8'));
}

/** A session of its own for a test. */
export async function openSession(hand = 'barrett8', object = 'lemon', contacts = 'lemon_6') {
  const text = await handgraft('grasp', '--hand', hand, '--object', object, '--contacts', contacts, '--keep', '--json');
  return JSON.parse(text).session_id;
}

/** The server that tests stop and start again. */
export const held = { server: null };

// === How it is done

/** Ends all programs that were started. */
export async function stopAll() {
  for (const child of [...children]) await stop(child);
  rmSync(downloads, { recursive: true, force: true });
}

/** All of them, or those that were asked for; ends the process. */
export async function runTests(tests) {
  held.server = await startServer();
  let failed = 0;
  try {
    const view = await startView();
    browser = await launch();
    for (const [name, test] of Object.entries(tests)) {
      if (only !== undefined && !name.includes(only)) continue;
      const begun = Date.now();
      let page;
      try {
        page = await test(view.address);
        if (page.broken) throw page.broken;
        console.log(`passed  ${name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
      } catch (error) {
        ++failed;
        console.log(`FAILED  ${name}: ${error.stack ?? error}`);
        for (const one of (await browser.pages()).slice(1)) {
          await picture(one, `failed_${failed}`).catch(() => undefined);
          console.log(await one.evaluate(() => { const { session, tools } = globalThis.handgraft; return JSON.stringify({ state: session.state, solution: session.solution?.revision, diagnosed: session.solution?.is_diagnosed, settings: session.settings?.state.revision, underWay: session.editing.underWay, busy: tools.isBusy, toasts: [...document.querySelectorAll('.toasts p')].map((p) => p.textContent) }); }).catch(String));
        }
      }
      for (const one of (await browser.pages()).slice(1)) await one.close();
    }
  } finally {
    await browser?.close();
    await stopAll();
  }
  process.exit(failed === 0 ? 0 : 1);
}
