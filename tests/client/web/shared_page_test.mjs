// shared_page_test.mjs BIN PACKAGES PICTURES DOMAIN [NAME]: pages beside each other and beside other programs, links for looking, files that pages
// become, names for screen readers, servers and networks that go. As page_test.mjs.

import assert from 'node:assert/strict';
import { existsSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { bin, browser, distance, dotOf, downloads, dragBy, factsOf, handgraft, held, kPatience_ms, kWaiting, ofServer, openPage, openSession, picture, rest, run, runTests, serverPose, settingsOf, sleep, startServer, startView, stop, typed, waitRevision, waitText } from './browser.mjs';

const tests = {
  async 'Two pages and the command line agree'(address) {
    const session = await openSession();
    const [one, two] = [await openPage(`${address}?session=${session}`), await openPage(`${address}?session=${session}`)];
    await rest(one);
    await rest(two);
    await one.bringToFront();
    await dragBy(one, await dotOf(one, 'thumb', 'hand'), 14, 10);
    await waitRevision(one, 1);
    await two.bringToFront();
    await waitRevision(two, (await factsOf(one)).revision);
    await waitText(two, '.people', /2 pages here.*guest \d+ laid thumb elsewhere on the hand/);
    const dragged = (await factsOf(two)).revision;
    await two.click('[data-patch=index] .switch');
    await waitRevision(two, dragged + 1);
    await typed(session, 'disable middle\n');
    const pose = await serverPose(session);
    for (const page of [one, two]) {
      await page.bringToFront();
      await waitRevision(page, pose.revision);
      const facts = await factsOf(page);
      assert.equal(facts.revision, pose.revision);
      const links = Object.values(pose.links_X_WL).map((X_WL) => X_WL.p_m);
      facts.links.forEach((link, i) => assert.ok(distance(link, links[i]) < 1e-5));
      await waitText(page, '.people', /another program switched middle off/);
    }
    await picture(two, 'editors');
    // Who shows another session, or leaves, is not here any more.
    const other = await openSession();
    await one.evaluate((id) => globalThis.handgraft.session.show(id), other);
    const alone = () => two.waitForFunction(() => !document.querySelector('.people').textContent.includes('pages here'), kWaiting);
    await alone();
    await one.evaluate((id) => globalThis.handgraft.session.show(id), session);
    await waitText(two, '.people', /2 pages here/);
    await one.goto('about:blank');
    await alone();
    await one.close();
    return two;
  },

  async 'Who only looks, looks'() {
    const session = await openSession();
    const view = await startView(String(session), '--read-only');
    const page = await openPage(view.address);
    const dot = await dotOf(page, 'thumb', 'hand');
    await dragBy(page, dot, 20, 10);
    assert.equal(await page.$eval('.modes', (element) => element.hidden), true);
    assert.equal(await page.$eval('[data-patch=thumb] .switch', (element) => element.disabled), true);
    assert.equal((await serverPose(session)).revision, 0);
    await stop(view.process);
    return page;
  },

  async 'A picture is saved, and the page as one file that needs no server'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    const client = await page.createCDPSession();
    await client.send('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: downloads });
    const save = async (text, file) => {
      await page.click('.menu summary');
      await page.evaluate((name) => [...document.querySelectorAll('.menu button')].find((one) => one.textContent.startsWith(name)).click(), text);
      const path = join(downloads, file);
      for (let waited = 0; waited < kPatience_ms && !existsSync(path); waited += 50) await sleep(50);
      await sleep(200);
      return path;
    };
    const png = await save('Picture', 'barrett8_lemon.png');
    assert.ok(statSync(png).size > 10000, 'the picture is none of one colour');
    const html = await save('Page as one file', 'barrett8_lemon.html');

    const cli = join(downloads, 'cli.html');
    if ((await run(join(bin, 'handgraft'), ['export', '--help'])).stdout.includes('html')) {
      await handgraft('export', String(session), '--format', 'html', '--out', cli);
    }
    for (const file of [html, cli].filter(existsSync)) {
      const alone = await browser.newPage();
      const wanted = [];
      alone.on('request', (request) => {
        if (!/^(file|data|blob):/.test(request.url())) wanted.push(request.url());
      });
      await alone.setOfflineMode(true);
      await alone.setViewport({ width: 900, height: 560 });
      await alone.goto(`file://${file}`);
      await alone.waitForFunction(() => globalThis.handgraft?.view.facts().handles.length > 0, kWaiting);
      assert.deepEqual((await factsOf(alone)).links, (await factsOf(page)).links);
      const dot = await dotOf(alone, 'thumb', 'hand');
      await dragBy(alone, { x: 250, y: 450 }, 120, 20);
      await sleep(300);
      const turned = await dotOf(alone, 'thumb', 'hand');
      assert.ok(Math.hypot(turned.x - dot.x, turned.y - dot.y) > 3, 'the view turns');
      assert.deepEqual(wanted, []);
      await picture(alone, file === html ? 'file' : 'file_by_export');
      await alone.close();
    }
    return page;
  },

  async 'Every control has a name'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    const nameless = [];
    const look = (node) => {
      if (['button', 'slider', 'checkbox', 'switch', 'spinbutton', 'combobox', 'tab', 'textbox'].includes(node.role) && !node.name) nameless.push(node.role);
      (node.children ?? []).forEach(look);
    };
    for (const tab of ['patches', 'joints', 'more']) {
      await page.click(`#to-${tab}`);
      look(await page.accessibility.snapshot());
    }
    assert.deepEqual(nameless, []);
    for (let i = 0; i < 2; ++i) {
      await page.click('[aria-label="Light or dark"]');
      await sleep(200);
      await picture(page, await page.evaluate(() => document.documentElement.dataset.theme));
    }
    return page;
  },

  async 'A server that ends and comes again is told, and the session goes on'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    await page.click('[data-patch=index] .switch');
    await waitRevision(page, 1);
    await sleep(5000); // it is saved while it rests
    await stop(held.server, 'SIGKILL');
    await page.waitForSelector('.banner:not([hidden])', { timeout: kPatience_ms });
    held.server = await startServer();
    await page.waitForSelector('.banner[hidden]', { timeout: kPatience_ms });
    await page.waitForFunction(() => globalThis.handgraft.session.solution?.is_diagnosed, kWaiting);
    await rest(page);
    assert.equal((await settingsOf(page)).patches.find((one) => one.name === 'index').enabled, false);
    // Revisions of the session that was opened again may begin anew.
    await page.click('[data-patch=index] .switch');
    const isOn = async () => (await settingsOf(page)).patches.find((one) => one.name === 'index').enabled;
    for (let waited = 0; !(await isOn()) && waited < kPatience_ms; waited += 200) await sleep(200);
    assert.equal(await isOn(), true);
    return page;
  },

  async 'A page that is loaded while the server is away shows its session once that is back'(address) {
    // One whose sessions outlive it.
    ofServer.push('--state', join(downloads, 'state'));
    await stop(held.server);
    held.server = await startServer();
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    await stop(held.server);
    await page.waitForSelector('.banner:not([hidden])', { timeout: kPatience_ms });
    await page.reload();
    await page.waitForFunction(() => globalThis.handgraft?.session.page > 0, kWaiting);
    await sleep(1000);
    held.server = await startServer();
    await page.waitForSelector('.banner[hidden]', { timeout: kPatience_ms });
    await page.waitForFunction(() => globalThis.handgraft.session.settings && globalThis.handgraft.view.facts().handles.length > 0, kWaiting);
    await rest(page);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.id), session);
    ofServer.length = 0;
    return page;
  },

  async 'A network that is gone for a while is told, and the page goes on'() {
    const session = await openSession();
    const view = await startView(String(session), '--port', '0');
    const page = await openPage(view.address);
    await rest(page);
    const port = new URL(view.address).port;
    await stop(view.process);
    await page.waitForSelector('.banner:not([hidden])', { timeout: kPatience_ms });
    const again = await startView(String(session), '--port', port);
    await page.waitForSelector('.banner[hidden]', { timeout: kPatience_ms });
    await page.click('[data-patch=thumb] .switch');
    await waitRevision(page, 1);
    await stop(again.process);
    return page;
  },
};

await runTests(tests);
