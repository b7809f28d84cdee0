// secured_page_test.mjs BIN PACKAGES PICTURES DOMAIN [NAME]: pages in a secured domain. As page_test.mjs.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import http from 'node:http';
import { join } from 'node:path';
import { bin, dotOf, downloads, dragBy, factsOf, handgraft, kWaiting, ofServer, openPage, openSession, picture, rest, runTests, sleep, startView, stop, waitRevision } from './browser.mjs';
import { openMotion, openMotionPage, point } from './motions.mjs';

const keys = join(downloads, 'keys');
const program = join(bin, 'handgraft');
execFileSync(program, ['keys', 'init', keys], { stdio: 'ignore' });
for (const role of ['server', 'editor', 'viewer']) execFileSync(program, ['keys', 'add', `a-${role}`, '--role', role, '--dir', keys], { stdio: 'ignore' });
ofServer.push('--identity', join(keys, 'a-server'));
process.env.HANDGRAFT_IDENTITY = join(keys, 'a-editor'); // of all programs that are not told otherwise

/** The page of a session: links hold a token, since others of this machine have no identity. */
const pageOf = (address, session) => {
  assert.match(address, /#token=[0-9a-f]{32}$/);
  return address.replace('#', `?session=${session}#`);
};

/** The page of somebody who may look and no more. */
const startLook = () => startView('--identity', join(keys, 'a-viewer'));

const upgrade = { connection: 'Upgrade', upgrade: 'websocket', 'sec-websocket-version': '13', 'sec-websocket-key': 'AAAAAAAAAAAAAAAAAAAAAA==' };

/** Without the token of its link nobody joins. */
const expectClosed = async (address) => {
  for (const query of ['', '?token=', `?token=${'0'.repeat(32)}`]) {
    const asked = http.get(new URL(`/live${query}`, address), { headers: upgrade });
    const status = await new Promise((resolve, reject) => {
      asked.on('response', (reply) => resolve(reply.resume().statusCode));
      asked.on('upgrade', () => resolve('joined'));
      asked.on('error', reject);
    });
    asked.destroy();
    assert.equal(status, 401, query);
  }
};

const tests = {
  async 'A viewer sees what an editor does, and changes nothing'(address) {
    await expectClosed(address);
    const session = await openSession('human20', 'lemon', 'lemon_6');
    const edits = await openPage(pageOf(address, session));
    const view = await startLook();
    const page = await openPage(pageOf(view.address, session));
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.mayEdit), false);
    assert.ok(await page.$eval('.modes', (modes) => modes.hidden), 'nothing is offered to drag');

    await rest(edits);
    await edits.bringToFront();
    await dragBy(edits, await dotOf(edits, 'thumb', 'hand'), 14, 10);
    await waitRevision(edits, 1);
    await rest(edits); // a drag is several edits
    const { revision } = await factsOf(edits);
    await page.waitForFunction((at) => globalThis.handgraft.session.solution.revision === at, kWaiting, revision);
    assert.deepEqual((await factsOf(page)).links, (await factsOf(edits)).links);

    // Another solution as a ghost, which the server poses; files, too.
    await page.bringToFront();
    await page.click('#to-more');
    await page.click('[aria-label="show solution 1 as a ghost"]');
    await page.waitForFunction(() => /solution 1/.test(document.querySelector('.shells').textContent), kWaiting);
    await picture(page, 'viewer');
    await assert.rejects(page.evaluate(() => globalThis.handgraft.session.link.edit(globalThis.handgraft.session.id, { kind: 'undo', steps: { count: 1 } })), /looking/);
    assert.match(await handgraft('sessions', '--json'), new RegExp(`"revision": *${revision}`));
    await stop(view.process);
    return page;
  },

  async 'A viewer watches a motion'() {
    const session = await openMotion();
    const view = await startLook();
    const page = await openMotionPage(pageOf(view.address, session));
    await point(page, 0.5);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.motion.frames.length), 26);
    await page.click('.timeline .play');
    await sleep(300);
    assert.ok(await page.evaluate(() => globalThis.handgraft.timeline.isPlaying));
    assert.ok(await page.$eval('.reach', (reach) => reach.hidden), 'nothing is offered to edit');
    await picture(page, 'viewer_motion');
    await stop(view.process);
    return page;
  },
};

await runTests(tests);
