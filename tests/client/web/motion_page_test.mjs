// motion_page_test.mjs BIN PACKAGES PICTURES DOMAIN [NAME]: a motion on the page, over time. As page_test.mjs.

import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { browser, distance, downloads, dragBy, factsOf, handgraft, kPatience_ms, kWaiting, openSession, picture, rest, runTests, sleep, waitText } from './browser.mjs';
import { framesOf, openMotion, openMotionPage, point, timeOf } from './motions.mjs';

const tests = {
  async 'A motion that the server has is opened in the dialog, and told from grasps'(address) {
    await openMotion();
    const page = await browser.newPage();
    await page.setViewport({ width: 1100, height: 700 });
    await page.goto(address);
    await page.waitForSelector('.empty:not([hidden]) button');
    await page.click('.empty button');
    await page.waitForSelector('.part[data-kind=contacts] optgroup option');
    await waitText(page, 'dialog .list', /tendon16 follows pull10 with box/);
    await page.select('.part[data-kind=hand] select', 'tendon16');
    await page.select('.part[data-kind=object] select', 'box');
    await page.select('.part[data-kind=contacts] select', 'motion pull10');
    await picture(page, 'open_motion');
    await page.click('dialog button.main');
    await page.waitForFunction(() => globalThis.handgraft.session.motion?.frames.length === 26, kWaiting);
    return page;
  },

  async 'A motion is scrubbed: the hand stands where the server has it'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`);
    const frames = await framesOf(page);
    assert.equal(frames.length, 26);
    for (const index of [0, 10, 25]) {
      await point(page, index / 25);
      const time_s = await timeOf(page);
      assert.ok(Math.abs(time_s - frames[index].time_s) < 0.02, `the bars lead to ${frames[index].time_s} s, not to ${time_s}`);
      // Exactly on a frame, by the slider's own value.
      await page.evaluate((at) => globalThis.handgraft.timeline.seek(at), frames[index].time_s);
      const { links, X_WO } = await factsOf(page);
      links.forEach((link, i) => assert.ok(distance(link, frames[index].X_WL[i].p_m) < 1e-6));
      assert.ok(distance(X_WO, frames[index].X_WO.p_m) < 1e-6);
    }
    // Between two frames it stands between them.
    await page.evaluate((at) => globalThis.handgraft.timeline.seek(at), 0.5 * (frames[10].time_s + frames[11].time_s));
    const { X_WO } = await factsOf(page);
    X_WO.forEach((x, i) => assert.ok(Math.abs(x - 0.5 * (frames[10].X_WO.p_m[i] + frames[11].X_WO.p_m[i])) < 1e-6));
    await picture(page, 'motion');
    return page;
  },

  async 'It is played by the keys, to its end or again and again'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`);
    await page.focus('canvas');
    await page.keyboard.press('Space');
    await page.waitForFunction(() => globalThis.handgraft.timeline.time_s > 0.3, kWaiting);
    await page.keyboard.press('Space');
    const paused = await timeOf(page);
    await sleep(300);
    assert.equal(await timeOf(page), paused);
    await page.keyboard.press('.');
    assert.ok((await timeOf(page)) > paused);

    await page.click('.timeline input[type=checkbox]'); // not again
    await point(page, 0.98);
    await page.click('.timeline .play');
    await page.waitForFunction(() => !globalThis.handgraft.timeline.isPlaying, kWaiting);
    assert.equal(await timeOf(page), (await framesOf(page)).at(-1).time_s);
    return page;
  },

  async 'Bars and plots tell when each patch is there'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`);
    const frames = await framesOf(page);
    const names = await page.$$eval('.bars .name', (all) => all.map((one) => one.textContent));
    assert.deepEqual(names, await page.evaluate(() => globalThis.handgraft.session.motion.description.patches));
    // The little finger lets go before the end: its bar ends there.
    const little = names.indexOf('little');
    const last = frames.filter((frame) => frame.patches.some((one) => one.patch === little && one.presence >= 0.5)).at(-1);
    assert.ok(last.time_s < frames.at(-1).time_s);
    const end = await page.$$eval('.bars .presence', (rows, row) => {
      const bar = rows[row].querySelector('i').getBoundingClientRect();
      const lane = rows[row].querySelector('.lane').getBoundingClientRect();
      return (bar.right - lane.left) / lane.width;
    }, little);
    assert.ok(Math.abs(end * frames.at(-1).time_s - last.time_s) < 0.15, `the bar ends at ${end}`);
    for (const kind of ['distances', 'angles', 'joints', 'depth']) {
      await page.select('.history select', kind);
      assert.ok(await page.$('#tab-time .uplot'), `there is a plot of ${kind}`);
      await picture(page, `motion_${kind}`);
    }
    // What counts now is in the table.
    await point(page, 1);
    await page.click('#to-patches');
    await page.waitForFunction(() => [...document.querySelectorAll('.patch .verdict')].filter((one) => !one.textContent.includes('not now')).length === 4, kWaiting);
    const counted = (count) => page.waitForFunction((all) => document.querySelector('.pill').textContent.endsWith(` of ${all} reached`), kWaiting, count);
    await counted(4);
    // What has faded by more than half is not, nor where it is the only one.
    const fade = async (count) => {
      await page.evaluate((patches) => {
        for (const frame of globalThis.handgraft.session.motion.frames)
          for (const patch of frame.patches.slice(0, patches)) patch.presence = 0.3;
      }, count);
      await point(page, 0.5);
      await point(page, 1);
    };
    await fade(1);
    await counted(3);
    await fade(5);
    await page.waitForFunction(() => document.querySelector('.pill').textContent === 'no contact', kWaiting);
    return page;
  },

  async 'As one file it plays without a server'(address) {
    const session = await openMotion();
    const page = await openMotionPage(`${address}?session=${session}`);
    const file = join(downloads, 'motion.html');
    await handgraft('motion', 'export', String(session), '--out', file);
    const client = await page.createCDPSession();
    await client.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: downloads });
    await page.click('.menu summary');
    await page.evaluate(() => [...document.querySelectorAll('.menu button')].find((one) => one.textContent.startsWith('Page as one file')).click());
    const saved = join(downloads, 'tendon16_box.html');
    for (let waited = 0; waited < kPatience_ms && !existsSync(saved); waited += 50) await sleep(50);
    await sleep(200);
    for (const one of [file, saved]) {
      const alone = await browser.newPage();
      const wanted = [];
      alone.on('request', (request) => {
        if (!/^(file|data|blob):/.test(request.url())) wanted.push(request.url());
      });
      await alone.setOfflineMode(true);
      await alone.setViewport({ width: 1100, height: 700 });
      await alone.goto(`file://${one}`);
      await alone.waitForFunction(() => globalThis.handgraft?.session.motion && globalThis.handgraft.view.hand, kWaiting);
      assert.equal((await framesOf(alone)).length, 26);
      await point(alone, 0.4);
      await point(page, 0.4);
      const [here, there] = [await factsOf(alone), await factsOf(page)];
      here.links.forEach((link, i) => assert.ok(distance(link, there.links[i]) < 1e-6));
      await alone.click('.timeline .play');
      await alone.waitForFunction(() => globalThis.handgraft.timeline.time_s > 1.1, kWaiting);
      for (const kind of ['joints', 'distances']) {
        await alone.select('.history select', kind);
        assert.ok(await alone.$('#tab-time .uplot'), `there is a plot of ${kind}`);
      }
      // The view turns.
      const eye = () => alone.evaluate(() => globalThis.handgraft.stage.camera.position.toArray());
      const before = await eye();
      await dragBy(alone, { x: 300, y: 200 }, 90, 20);
      await alone.waitForFunction((was) => {
        const is = globalThis.handgraft.stage.camera.position.toArray();
        return Math.hypot(...is.map((each, i) => each - was[i])) > 0.01;
      }, kWaiting, before); // the view turns
      assert.deepEqual(wanted, []);
      await picture(alone, 'motion_file');
      await alone.close();
    }
    return page;
  },

  async 'From a motion to a grasp and back'(address) {
    const motion = await openMotion();
    const grasp = await openSession();
    const page = await openMotionPage(`${address}?session=${motion}`);
    await page.evaluate((id) => globalThis.handgraft.session.show(id), grasp);
    await page.waitForFunction(() => globalThis.handgraft.session.settings !== null, kWaiting);
    await rest(page);
    assert.equal(await page.$eval('.timeline', (element) => element.hidden), true);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.mayEdit), true);
    await page.evaluate((id) => globalThis.handgraft.session.show(id), motion);
    await page.waitForFunction(() => globalThis.handgraft.session.motion !== null, kWaiting);
    assert.equal(await page.$eval('.timeline', (element) => element.hidden), false);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.mayEdit), true);
    return page;
  },
};

await runTests(tests);
