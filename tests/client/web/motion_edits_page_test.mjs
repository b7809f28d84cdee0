// motion_edits_page_test.mjs BIN PACKAGES PICTURES DOMAIN [NAME]: a motion is edited on the page, about a moment or all of it, by real
// mouse and keys; what came of it is read from the page's state and from the server's. As page_test.mjs.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { distance, dotOf, downloads, dragBy, factsOf, handgraft, kWaiting, picture, runTests, sleep, startView, still, stop, typed, waitText } from './browser.mjs';
import { framesOf, openMotion, openMotionPage, point, timeOf } from './motions.mjs';

const kMargin_s = 0.5; // on both sides of what an edit reaches, frames are solved anew (core/retargeting/edited_motion.h)

const settingsOf = (page) => page.evaluate(() => globalThis.handgraft.session.settings);
const revisionOf = (page) => page.evaluate(() => globalThis.handgraft.session.state.revision);

/** Waits until the motion answers that revision or a later one, and nothing is on its way. */
async function solved(page, revision) {
  await page.waitForFunction(
    (least) => {
      const { session, tools } = globalThis.handgraft;
      const { state, motion, settings } = session;
      return (
        !tools.isBusy && session.editing.underWay === 0 && state.phase === 'ready' && state.revision >= least && motion.revision === state.revision &&
        motion.newest === state.revision && motion.unshaped.size === 0 && settings?.state.revision === state.revision
      );
    },
    kWaiting,
    revision,
  );
}

async function edited(page, act) {
  const before = await revisionOf(page);
  await act();
  await solved(page, before + 1);
}

async function pressed(page, ...keys) {
  for (const key of keys.slice(0, -1)) await page.keyboard.down(key);
  await page.keyboard.press(keys.at(-1));
  for (const key of keys.slice(0, -1)) await page.keyboard.up(key);
}

/** The page's frames are the server's. */
async function assertSame(page, session) {
  const file = join(downloads, 'motion.json');
  await handgraft('export', String(session), '--format', 'json', '--out', file);
  const { frames } = JSON.parse(readFileSync(file, 'utf8'));
  const shown = await framesOf(page);
  if (frames.length <= 600) assert.equal(shown.length, frames.length);
  for (const { index, time_s, joint_positions } of shown) {
    const its = frames[index];
    assert.ok(Math.abs(time_s - its.time_s) < 1e-9);
    joint_positions.forEach((q, joint) => assert.ok(Math.abs(q - its.joints[joint]) < 1e-9, `frame ${index}, joint ${joint}`));
  }
  return shown;
}

const isSame = (a, b) => a.joint_positions.every((q, i) => q === b.joint_positions[i]);

/** Of two answers: those that an edit at `time_s` may change differ in some, all others in none. */
function assertChangedAbout(before, after, time_s, reach_s) {
  const changed = after.filter((frame, k) => !isSame(frame, before[k])).map((frame) => frame.time_s);
  assert.ok(changed.length > 0, 'frames are solved anew');
  const far = changed.filter((time) => Math.abs(time - time_s) > reach_s + kMargin_s + 0.11);
  assert.deepEqual(far, [], `frames far from ${time_s} s stay as they are`);
}

/** Sees to it that edits reach so far, by the controls. */
async function reach(page, seconds) {
  await page.select('[aria-label="what edits hold for"]', seconds === null ? 'all' : 'moment');
  if (seconds === null) return;
  const input = await page.$('[aria-label^="how far edits reach"]');
  await input.click({ clickCount: 3 });
  await page.keyboard.type(String(seconds));
  await page.keyboard.press('Tab');
}

const tests = {
  async 'A contact is dragged over the hand at a moment: the frames about it change, and all is undone at once'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`);
    await solved(page, 0);
    const before = await framesOf(page);
    await reach(page, 0.2);
    await point(page, 0.4);
    const time_s = await timeOf(page);
    // The band is as wide as edits reach.
    const band = await page.evaluate(() => {
      const lane = document.querySelector('.bars .lane').getBoundingClientRect();
      const { left, right } = document.querySelector('.band').getBoundingClientRect();
      return [(left - lane.left) / lane.width, (right - lane.left) / lane.width];
    });
    [time_s - 0.2, time_s + 0.2].forEach((edge, i) => assert.ok(Math.abs(band[i] * 2.5 - edge) < 0.06, `the band ends at ${band[i] * 2.5} s, not ${edge}`));

    const dot = await dotOf(page, 'index', 'hand');
    const poseBefore = await factsOf(page);
    await edited(page, () => dragBy(page, dot, 9, 12));
    const after = await assertSame(page, session);
    assertChangedAbout(before, after, time_s, 0.2);
    const poseAfter = await factsOf(page);
    assert.ok(poseBefore.links.some((link, i) => distance(link, poseAfter.links[i]) > 1e-5), 'the hand that is shown is posed anew');
    const { timed } = await settingsOf(page);
    assert.deepEqual(timed.map(({ text, falloff_s }) => [text, falloff_s]), [['root index hand', 0.2]]);
    assert.ok(Math.abs(timed[0].time_s - time_s) < 1e-9);
    await picture(page, 'motion_edited');

    await page.focus('canvas');
    await edited(page, () => pressed(page, 'Control', 'z'));
    (await framesOf(page)).forEach((frame, k) => assert.ok(isSame(frame, before[k]), `frame ${k} is as it was, to the last bit`));
    assert.deepEqual((await settingsOf(page)).timed, []);
    await edited(page, () => pressed(page, 'Control', 'y'));
    assert.ok((await settingsOf(page)).timed.length > 0);
    return page;
  },

  async 'On the object, too, where the outline goes along, and a direction is turned'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`);
    await solved(page, 0);
    const before = await framesOf(page);
    await point(page, 0.4);
    const time_s = await timeOf(page);
    await page.click('#to-patches');
    await page.click('[data-patch=index] .row');
    await edited(page, async () => dragBy(page, await dotOf(page, 'index', 'object'), 6, 8));
    const moved = await assertSame(page, session);
    assertChangedAbout(before, moved, time_s, 0.3);
    const nearest = moved.reduce((best, frame, k) => (Math.abs(frame.time_s - time_s) < Math.abs(moved[best].time_s - time_s) ? k : best), 0);
    const index = await page.evaluate(() => globalThis.handgraft.session.motion.description.patches.indexOf('index'));
    const outline = (frames) => frames[nearest].patches.find((one) => one.patch === index).outline_O_m;
    assert.ok(distance(outline(before).slice(0, 3), outline(moved).slice(0, 3)) > 1e-3, 'the outline is elsewhere on the object');

    const knob = await dotOf(page, 'index', 'hand', 'direction');
    const root = await dotOf(page, 'index', 'hand');
    const [ax, ay] = [knob.x - root.x, knob.y - root.y];
    await edited(page, () => dragBy(page, knob, -0.6 * ay, 0.6 * ax));
    assert.match((await settingsOf(page)).timed.at(-1).text, /^dir index hand/);
    await assertSame(page, session);
    return page;
  },

  async 'Switches, weights and joints hold about the moment, or for all of it'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`);
    await solved(page, 0);
    const before = await framesOf(page);
    await point(page, 0.4);
    await page.click('#to-patches');
    await edited(page, () => page.click('[data-patch=thumb] .switch'));
    assertChangedAbout(before, await assertSame(page, session), await timeOf(page), 0.3);
    assert.equal(await page.$eval('[data-patch=thumb] .switch', (one) => one.checked), false);
    await point(page, 0.05); // at another time it is on
    await page.waitForFunction(() => document.querySelector('[data-patch=thumb] .switch').checked, kWaiting);
    await point(page, 0.4);

    // By the keys: for all of the motion.
    await reach(page, null);
    await page.focus('[data-patch=index] .switch');
    await edited(page, () => page.keyboard.press('Space'));
    const settings = await settingsOf(page);
    assert.equal(settings.patches.find((one) => one.name === 'index').enabled, false);
    assert.equal(settings.timed.length, 1);
    const without = await assertSame(page, session);
    assert.ok(without.every((frame, k) => !isSame(frame, before[k])), 'every frame is solved without it');

    await reach(page, 0.2);
    await page.click('#to-joints');
    const name = settings.joints[2].name;
    await edited(page, async () => {
      await page.focus(`input[type=range][aria-label^="${name},"]`);
      for (let i = 0; i < 3; ++i) await page.keyboard.press('ArrowLeft');
    });
    assert.match((await settingsOf(page)).timed.at(-1).text, new RegExp(`^soft ${name} `));
    await edited(page, () => page.click(`[aria-label="lock ${name}"]`));
    assert.equal((await settingsOf(page)).timed.at(-1).text, `lock ${name}`);
    await page.waitForFunction((label) => document.querySelector(`[aria-label="${label}"]`).getAttribute('aria-pressed') === 'true', kWaiting, `lock ${name}`);
    await page.evaluate(() => document.querySelectorAll('.joint details').forEach((one) => (one.open = true)));
    await edited(page, async () => {
      const input = await page.$(`[aria-label^="upper limit of ${settings.joints[3].name},"]`);
      await input.click({ clickCount: 3 });
      await page.keyboard.type('40');
      await page.keyboard.press('Tab');
    });
    assert.match((await settingsOf(page)).timed.at(-1).text, /^limit /);
    await assertSame(page, session);
    await picture(page, 'motion_joints_edited');
    return page;
  },

  async 'A finger is dragged at a moment, and stays there; for all of it, it stays, too'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`, { width: 1280, height: 800 });
    await solved(page, 0);
    await point(page, 0.4);
    await page.focus('canvas');
    await page.keyboard.press('2');
    const grip = () => page.evaluate(() => {
      const { stage, view } = globalThis.handgraft;
      const canvas = stage.canvas.getBoundingClientRect();
      for (let y = 20; y < stage.size.y - 260; y += 8) {
        for (let x = 130; x < stage.size.x - 20; x += 8) {
          const hit = view.hand.pickLink(stage.rayAt(x, y));
          if (hit !== null && view.hand.links.indexOf(hit.link) > 3) return { x: canvas.x + x, y: canvas.y + y, link: hit.link.name };
        }
      }
      return null;
    });
    await still(page);
    const at = await grip();
    assert.ok(at, 'a finger is seen');
    const before = await framesOf(page);
    await edited(page, () => dragBy(page, at, 24, -12));
    assert.equal((await settingsOf(page)).timed.at(-1).text, `drag ${at.link}`);
    assertChangedAbout(before, await assertSame(page, session), await timeOf(page), 0.3);

    await edited(page, () => pressed(page, 'Control', 'z'));
    await reach(page, null);
    await still(page);
    const again = await grip();
    await edited(page, () => dragBy(page, again, 24, -12));
    assert.deepEqual((await settingsOf(page)).held.map((one) => one.link), [again.link]);
    await page.waitForSelector('.modes .held:not([hidden])');
    await edited(page, () => page.click('.modes .held'));
    assert.deepEqual((await settingsOf(page)).held, []);
    return page;
  },

  async 'Marks lead to what was edited, and take it back whatever came after'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`);
    await solved(page, 0);
    const before = await framesOf(page);
    await page.click('#to-patches');
    for (const [share, patch] of [[0.2, 'thumb'], [0.6, 'index']]) {
      await point(page, share);
      await edited(page, () => page.click(`[data-patch=${patch}] .switch`));
    }
    await page.waitForFunction(() => document.querySelectorAll('.marks .mark').length === 2, kWaiting);
    await picture(page, 'motion_marks');
    await page.click('.marks .mark:nth-child(1)');
    const { timed } = await settingsOf(page);
    assert.ok(Math.abs((await timeOf(page)) - timed[0].time_s) < 1e-6, 'a mark leads to its time');
    // The first one goes, by the keys; the second stays.
    await page.focus('.marks .mark:nth-child(1)');
    await edited(page, () => page.keyboard.press('Delete'));
    assert.deepEqual((await settingsOf(page)).timed.map((one) => one.text), ['disable index']);
    await assertSame(page, session);
    // The other one by the list.
    await page.click('#to-time');
    await page.waitForFunction(() => document.querySelectorAll('.timed .small').length === 1, kWaiting);
    await edited(page, () => page.click('.timed .small'));
    (await framesOf(page)).forEach((frame, k) => assert.ok(isSame(frame, before[k]), `frame ${k} is as it was`));
    assert.equal(await page.$$eval('.marks .mark', (all) => all.length), 0);
    // What another edit came before is not taken back by a number that means another one now.
    await point(page, 0.5);
    await page.click('#to-patches');
    await edited(page, () => page.click('[data-patch=thumb] .switch'));
    await page.evaluate(() => {
      globalThis.handgraft.session.settings.state.revision -= 1; // as if it had not been heard of
    });
    await page.focus('.marks .mark');
    await page.keyboard.press('Delete');
    await waitText(page, '.toasts', /is at revision/);
    assert.equal((await settingsOf(page)).timed.length, 1);
    return page;
  },

  async 'Of a long motion every frame about the time that is shown is there, edited or not'(address) {
    const session = await openMotion(260); // 651 frames: every second is shown
    const page = await openMotionPage(`${address}?session=${session}`);
    await solved(page, 0);
    const isFineAt = (time_s) =>
      page.waitForFunction(
        (at) => {
          const indices = globalThis.handgraft.session.motion.frames.filter((frame) => Math.abs(frame.time_s - at) < 0.2).map((frame) => frame.index);
          return indices.length > 100 && indices.every((index, k) => k === 0 || index === indices[k - 1] + 1);
        },
        kWaiting,
        time_s,
      );
    await reach(page, 0.1);
    await point(page, 0.4);
    const time_s = await timeOf(page);
    await isFineAt(time_s);
    const far = (await framesOf(page)).filter((frame) => Math.abs(frame.time_s - time_s) > 0.3);
    assert.ok(far.every((frame) => frame.index % 2 === 0), 'elsewhere every second frame is enough');
    await edited(page, async () => dragBy(page, await dotOf(page, 'index', 'hand'), 9, 12));
    await isFineAt(time_s);
    assert.ok((await assertSame(page, session)).length > 325);

    // For all of it: more frames than are told at once, and no less shown.
    await reach(page, null);
    await page.click('#to-patches');
    await edited(page, () => page.click('[data-patch=little] .switch'));
    await assertSame(page, session);
    await point(page, 0.8);
    await isFineAt(await timeOf(page));
    await assertSame(page, session);
    return page;
  },

  async 'Two pages and the command line agree on a motion; who only looks sees it'(address) {
    const session = await openMotion();
    const [one, two] = [await openMotionPage(`${address}?session=${session}`), await openMotionPage(`${address}?session=${session}`)];
    const view = await startView(String(session), '--read-only');
    const looker = await openMotionPage(view.address);
    await one.bringToFront();
    await solved(one, 0);
    await point(one, 0.4);
    await edited(one, async () => dragBy(one, await dotOf(one, 'index', 'hand'), 9, 12));
    await typed(session, 'at 0.5 0.2\ndisable thumb\nshow times\n');
    const revision = await revisionOf(one);
    for (const page of [one, two, looker]) {
      await page.bringToFront();
      await solved(page, Math.max(2, revision));
      await assertSame(page, session);
      await page.waitForFunction(() => document.querySelectorAll('.marks .mark').length === 2, kWaiting);
      await waitText(page, '.people', /another program switched thumb off at 0.5 s/);
    }
    await picture(two, 'motion_editors');
    // Only looking: nothing to press, and a drag turns the view.
    assert.equal(await looker.$eval('.reach', (element) => element.hidden), true);
    await point(looker, 0.4);
    await dragBy(looker, await dotOf(looker, 'index', 'hand'), 9, 12);
    await looker.focus('.marks .mark');
    await looker.keyboard.press('Delete');
    await sleep(500);
    assert.equal(await revisionOf(looker), await revisionOf(two));
    assert.equal((await settingsOf(looker)).timed.length, 2);
    await looker.close();
    await stop(view.process);
    await one.close();
    return two;
  },
};

await runTests(tests);
