// page_test.mjs BIN PACKAGES PICTURES DOMAIN [NAME]: the page in a real browser, by real mouse, keys and touch, on a real server.
// What is done is read from the page's state and from the server's, through `handgraft` itself. Without a browser: 77.

import assert from 'node:assert/strict';
import { browser, distance, domain, dotOf, dragBy, factsOf, handgraft, held, kWaiting, openPage, openSession, picture, rest, runTests, serverPose, settingsOf, sleep, start, still, stop, typed, waitRevision, waitText } from './browser.mjs';

// === The tests

/** Takes the gizmo by an arrow, and moves it along. */
async function dragGizmo(page) {
  // Along the arrow that is seen from the side most: the end of it is where the gizmo is taken.
  const grip = await page.evaluate(() => {
    const { stage, tools } = globalThis.handgraft;
    const canvas = stage.canvas.getBoundingClientRect();
    const origin = tools.proxy.position;
    const at = (dx, dy, dz) => {
      const p = origin.clone();
      p.x += dx; p.y += dy; p.z += dz;
      return stage.project(p);
    };
    const zero = at(0, 0, 0);
    const arms = [at(0.02, 0, 0), at(0, 0.02, 0), at(0, 0, 0.02)].map((p) => ({ x: p.x - zero.x, y: p.y - zero.y }));
    const longest = arms.sort((a, b) => Math.hypot(b.x, b.y) - Math.hypot(a.x, a.y))[0];
    const length = Math.hypot(longest.x, longest.y);
    return { x: canvas.x + zero.x, y: canvas.y + zero.y, dx: longest.x / length, dy: longest.y / length };
  });
  let taken = null;
  for (let reach = 30; reach < 160 && taken === null; reach += 6) {
    await page.mouse.move(grip.x + reach * grip.dx, grip.y + reach * grip.dy);
    if (await page.evaluate(() => /^[XYZ]$/.test(globalThis.handgraft.tools.gizmo.axis ?? ''))) taken = reach;
  }
  assert.ok(taken, 'an arrow of the gizmo is under the pointer');
  await dragBy(page, { x: grip.x + taken * grip.dx, y: grip.y + taken * grip.dy }, 25 * grip.dx, 25 * grip.dy);
}

const tests = {
  async 'A contact is laid elsewhere by dragging its dot over the hand'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    const before = await factsOf(page);
    const rootOf = async () => (await settingsOf(page)).patches.find((patch) => patch.name === 'thumb').root_S;
    const rootBefore = await rootOf();
    await dragBy(page, await dotOf(page, 'thumb', 'hand'), 14, 10);
    await waitRevision(page, 1);
    const after = await factsOf(page);
    assert.notDeepEqual(await rootOf(), rootBefore);
    assert.ok(before.links.some((link, i) => distance(link, after.links[i]) > 1e-4), 'the hand is posed anew');
    await picture(page, 'root');

    // The server has the same pose.
    const pose = await serverPose(session);
    assert.equal(pose.revision, after.revision);
    const links = Object.values(pose.links_X_WL).map((X_WL) => X_WL.p_m);
    after.links.forEach((link, i) => assert.ok(distance(link, links[i]) < 1e-5, 'the page shows the server’s pose'));

    // The whole drag is undone at once, by the keys.
    await page.keyboard.down('Control');
    await page.keyboard.press('z');
    await page.keyboard.up('Control');
    await waitRevision(page, after.revision + 1);
    assert.deepEqual(await rootOf(), rootBefore);
    return page;
  },

  async 'A whole drag is undone and done again at once, after other edits and once the page is loaded again, too'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    const rootOf = async () => (await settingsOf(page)).patches.find((patch) => patch.name === 'thumb').root_S;
    const revision = () => page.evaluate(() => globalThis.handgraft.session.state.revision);
    const pressed = async (key, times = 1) => {
      const before = await revision();
      await page.keyboard.down('Control');
      for (let i = 0; i < times; ++i) await page.keyboard.press(key);
      await page.keyboard.up('Control');
      await waitRevision(page, before + 1);
    };
    // The answer may be there before the click is known to be done.
    const switched = async (patch) => {
      const before = await revision();
      await page.click(`[data-patch=${patch}] .switch`);
      await waitRevision(page, before + 1);
    };
    const before = await rootOf();
    await dragBy(page, await dotOf(page, 'thumb', 'hand'), 14, 10);
    await waitRevision(page, 2);
    const dragged = await rootOf();
    await pressed('z');
    assert.deepEqual(await rootOf(), before);
    await pressed('y');
    assert.deepEqual(await rootOf(), dragged);

    // One edit more, undone: the drag is still one step. Loaded again, too.
    await switched('index');
    await pressed('z');
    await page.reload();
    await page.waitForFunction(() => globalThis.handgraft?.session.settings, kWaiting);
    await rest(page);
    await pressed('z');
    assert.deepEqual(await rootOf(), before);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.state.undo_count), 0);
    await pressed('y');
    assert.deepEqual(await rootOf(), dragged);

    // Pressed faster than the server answers, and more often than there are steps: nothing is complained about.
    await pressed('z', 4);
    await page.waitForFunction(() => globalThis.handgraft.session.state.undo_count === 0, kWaiting);
    await sleep(300);
    assert.equal(await page.$('.toasts .wrong'), null);
    assert.deepEqual(await rootOf(), before);
    // What is edited behind undone steps is one of its own.
    await switched('index');
    await page.click('[data-patch=ring] .row');
    await page.focus('canvas');
    for (let i = 0; i < 3; ++i) await page.keyboard.press('ArrowLeft');
    await rest(page);
    const { undo_count: count } = await page.evaluate(() => globalThis.handgraft.session.state);
    await pressed('z');
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.state.undo_count), count - 1);
    return page;
  },

  async 'A finger on a touch screen drags a root over the object'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`, { touch: true });
    await rest(page);
    await page.tap('[data-patch=thumb] .row');
    const dot = await dotOf(page, 'thumb', 'object');
    await page.touchscreen.touchStart(dot.x, dot.y);
    for (let i = 1; i <= 8; ++i) {
      await page.touchscreen.touchMove(dot.x - 2 * i, dot.y + i);
      await sleep(20);
    }
    await page.touchscreen.touchEnd();
    await waitRevision(page, 1);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.state.last_edit), 'root thumb object');
    const moved = await dotOf(page, 'thumb', 'object');
    assert.ok(distance(moved.p_W, dot.p_W) > 0.001, 'the root is elsewhere');
    return page;
  },

  async 'A direction is turned by its handle'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    await page.click('[data-patch=thumb] .row');
    await page.evaluate(() => globalThis.handgraft.stage.controls.dolly(0.15, false));
    await still(page);
    const before = (await settingsOf(page)).patches.find((patch) => patch.name === 'thumb');
    const knobs = (await factsOf(page)).handles.filter((one) => one.kind === 'direction');
    assert.ok(knobs.length > 0, 'the patch that is chosen has an arrow');
    const knob = await dotOf(page, 'thumb', knobs[0].side, 'direction');
    const root = await dotOf(page, 'thumb', knobs[0].side);
    const [ax, ay] = [knob.x - root.x, knob.y - root.y];
    await dragBy(page, knob, -0.6 * ay, 0.6 * ax);
    await waitRevision(page, 1);
    const after = (await settingsOf(page)).patches.find((patch) => patch.name === 'thumb');
    const key = knobs[0].side === 'object' ? 'direction_O' : 'direction_S';
    assert.ok(distance(before[key], after[key]) > 0.1, 'it points elsewhere');
    return page;
  },

  async 'Fingers are dragged where they are pulled'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    await page.focus('canvas');
    await page.keyboard.press('2');
    assert.equal(await page.evaluate(() => globalThis.handgraft.tools.mode), 'fingers');
    // Any place where a finger is under the pointer.
    const at = await page.evaluate(() => {
      const { stage, view } = globalThis.handgraft;
      const last = view.hand.links.length - 1;
      for (let y = 20; y < stage.size.y - 60; y += 8) {
        for (let x = 110; x < stage.size.x - 20; x += 8) {
          const hit = view.hand.pickLink(stage.rayAt(x, y));
          if (hit !== null && view.hand.links.indexOf(hit.link) === last) return { x, y };
        }
      }
      return null;
    });
    assert.ok(at, 'a finger is seen');
    const box = await (await page.$('canvas')).boundingBox();
    // How far what was gripped is from where the pointer let it go, in pixels.
    const missed = () => page.evaluate(([x, y]) => {
      const { stage, session, view } = globalThis.handgraft;
      const [held] = session.solution.held;
      if (held === undefined) return Infinity;
      const link = view.hand.links.find((one) => one.name === held.link);
      const p = stage.project(stage.controls.camera.position.clone().fromArray(held.p_L_m).applyMatrix4(link.group.matrix));
      return Math.hypot(p.x - x, p.y - y);
    }, [at.x + 30, at.y - 20]);
    await dragBy(page, { x: box.x + at.x, y: box.y + at.y }, 30, -20);
    await waitRevision(page, 1);
    assert.match(await page.evaluate(() => globalThis.handgraft.session.state.last_edit), /^drag/);
    assert.ok((await missed()) < 3, `it is where it was pulled to, ${await missed()} pixels off`);
    await picture(page, 'fingers');
    // It stays there, whatever else is done, until it is let go.
    const { revision } = await factsOf(page);
    await page.click('[data-patch=index] .switch');
    await waitRevision(page, revision + 1);
    assert.ok((await missed()) < 3, `it is still there, ${await missed()} pixels off`);
    await page.click('.modes .held');
    await waitRevision(page, revision + 2);
    assert.equal(await page.$eval('.modes .held', (element) => element.hidden), true);
    return page;
  },

  async 'The object is moved by its arrows'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    await page.click('.modes button:nth-child(3)');
    await sleep(300);
    await still(page);
    const before = (await factsOf(page)).X_WO;
    await dragGizmo(page);
    await waitRevision(page, 1);
    assert.ok(distance((await factsOf(page)).X_WO, before) > 1e-3, 'the object is elsewhere');
    return page;
  },

  async 'The palm is moved by its arrows and turned by keys, stays there, and is let go'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`, { width: 1280, height: 720 });
    await rest(page);
    const palmOf = () => page.evaluate(() => globalThis.handgraft.session.solution.X_WL[0]);
    const before = await palmOf();
    await page.focus('canvas');
    await page.keyboard.press('4');
    await still(page);
    await dragGizmo(page);
    await waitRevision(page, 1);
    const moved = await palmOf();
    assert.ok(distance(before.p_m, moved.p_m) > 0.003, 'the palm is elsewhere');
    const { held } = await page.evaluate(() => globalThis.handgraft.session.solution);
    assert.deepEqual(held.map((one) => one.link), ['palm']);
    await picture(page, 'palm');
    // The whole drag is undone at once.
    const revision = await page.evaluate(() => globalThis.handgraft.session.state.revision);
    await page.keyboard.down('Control');
    await page.keyboard.press('z');
    await page.keyboard.up('Control');
    await waitRevision(page, revision + 1);
    assert.ok(distance(before.p_m, (await palmOf()).p_m) < 1e-6);

    // By keys: Shift turns.
    await page.keyboard.down('Shift');
    for (let i = 0; i < 3; ++i) {
      await page.keyboard.press('ArrowLeft');
      await rest(page);
    }
    await page.keyboard.up('Shift');
    await page.keyboard.press('ArrowUp');
    await waitRevision(page, revision + 5);
    const turned = await palmOf();
    const cosine = Math.abs(before.q_wxyz.reduce((sum, q, i) => sum + q * turned.q_wxyz[i], 0));
    assert.ok(2 * Math.acos(Math.min(1, cosine)) > 0.1, 'it is turned');
    await page.click('.modes .held');
    await waitRevision(page, revision + 6);
    assert.equal(await page.$eval('.modes .held', (element) => element.hidden), true);
    assert.equal((await page.evaluate(() => globalThis.handgraft.session.solution.held)).length, 0);
    return page;
  },

  async 'The side switches, weighs, bends, locks, limits and chooses, also by keys'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    const patch = async (name) => (await settingsOf(page)).patches.find((one) => one.name === name);
    const joint = async (name) => (await settingsOf(page)).joints.find((one) => one.name === name);
    const revision = async () => (await page.evaluate(() => globalThis.handgraft.session.state.revision));
    const edited = async (act) => {
      const before = await revision();
      await act();
      await waitRevision(page, before + 1);
    };

    // Hovering tells which dots are whose, and the other way round.
    await page.hover('[data-patch=index]');
    assert.equal(await page.evaluate(() => globalThis.handgraft.view.chosen), 'index');
    const dot = await dotOf(page, 'thumb', 'hand');
    await page.mouse.move(dot.x, dot.y);
    await page.waitForSelector('[data-patch=thumb].hovered');

    await edited(() => page.click('[data-patch=index] .switch'));
    assert.equal((await patch('index')).enabled, false);
    await page.focus('[data-patch=index] .switch');
    await edited(() => page.keyboard.press('Space'));
    assert.equal((await patch('index')).enabled, true);

    await page.click('#to-joints');
    const name = (await settingsOf(page)).joints[1].name;
    await edited(async () => {
      await page.focus(`input[type=range][aria-label^="${name},"]`);
      for (let i = 0; i < 3; ++i) await page.keyboard.press('ArrowLeft');
    });
    assert.equal((await joint(name)).soft, true);
    // It comes to what was asked for, which its row tells.
    const isAt = async () => {
      const position = await page.evaluate((of) => globalThis.handgraft.session.solution.joint_positions[globalThis.handgraft.session.state.joint_names.indexOf(of)], name);
      return ((position - (await joint(name)).prior) * 180) / Math.PI;
    };
    assert.ok(Math.abs(await isAt()) < 0.5, `${name} is ${await isAt()} degrees from where it was put`);
    const noteOf = () => page.evaluate((of) => document.querySelector(`[aria-label="lock ${of}"]`).closest('.joint').querySelector('.note').textContent, name);
    assert.match(await noteOf(), new RegExp(`held at ${Math.round(((await joint(name)).prior * 180) / Math.PI)}°`));
    await edited(() => page.click(`[aria-label="lock ${name}"]`));
    assert.equal((await joint(name)).locked, true);
    await edited(() => page.click(`[aria-label="lock ${name}"]`));

    await page.evaluate(() => document.querySelectorAll('.joint details').forEach((one) => (one.open = true)));
    await edited(async () => {
      const input = await page.$(`[aria-label^="upper limit of ${name},"]`);
      await input.click({ clickCount: 3 });
      await page.keyboard.type('40');
      await page.keyboard.press('Tab');
    });
    assert.ok(Math.abs((await joint(name)).upper - (40 * Math.PI) / 180) < 1e-9);
    // The lower one follows at once, and takes nothing of the upper one, nor the other way round.
    const { lower: untouched } = await joint(name);
    assert.equal(untouched, (await joint(name)).model_lower, 'to the last digit');
    await edited(async () => {
      for (const [side, degrees] of [['upper', '33.3'], ['lower', '11']]) {
        const input = await page.$(`[aria-label^="${side} limit of ${name},"]`);
        await input.click({ clickCount: 3 });
        await page.keyboard.type(degrees);
      }
      await page.keyboard.press('Tab');
    });
    await page.waitForFunction((of) => globalThis.handgraft.session.settings.joints.find((one) => one.name === of).lower > 0.1, kWaiting, name);
    await rest(page);
    assert.ok(Math.abs((await joint(name)).upper - (33.3 * Math.PI) / 180) < 1e-9);
    assert.ok(Math.abs((await joint(name)).lower - (11 * Math.PI) / 180) < 1e-9);

    // The arrows move the root of the contact that is chosen.
    await page.click('#to-patches');
    await page.click('[data-patch=thumb] .row');
    await edited(async () => {
      await page.focus('[aria-label="weight of thumb"]');
      await page.keyboard.press('End');
    });
    assert.equal((await patch('thumb')).weight, 10);
    assert.match(await page.$eval('[data-patch=thumb] .details output', (one) => one.textContent), /^× 10$/);
    const before = (await patch('thumb')).root_S;
    await page.focus('canvas');
    await edited(() => page.keyboard.press('ArrowLeft'));
    assert.notDeepEqual((await patch('thumb')).root_S, before);

    await page.click('#to-more');
    await picture(page, 'more');
    const minima = await page.$$('[aria-label=Minima] .choice');
    if (minima.length > 1) {
      await edited(() => minima[1].click());
      assert.match(await page.evaluate(() => globalThis.handgraft.session.state.last_edit), /^choose/);
    }
    // Twice at the same place keeps it twice, and goes back to nothing.
    const keep = await page.evaluateHandle(() => [...document.querySelectorAll('button')].find((one) => one.textContent === 'Keep this state'));
    await keep.evaluate((one) => one.scrollIntoView({ block: 'center' }));
    const at = await keep.boundingBox();
    await page.mouse.click(at.x + at.width / 2, at.y + at.height / 2);
    await page.waitForFunction(() => globalThis.handgraft.session.settings.snapshots.length === 1, kWaiting);
    await sleep(300);
    await page.mouse.click(at.x + at.width / 2, at.y + at.height / 2);
    await page.waitForFunction(() => globalThis.handgraft.session.settings.snapshots.length === 2, kWaiting);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.state.last_edit), 'snapshot state-2');
    return page;
  },

  async 'What came of it is told: contacts without a place, others in the way, none that counts, and the notes'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`, { width: 1280, height: 720 });
    await rest(page);
    const pill = () => page.$eval('.pill', (one) => [one.textContent, one.dataset.tone]);
    // The Barrett has three fingers, and six contacts are asked for.
    assert.deepEqual(await pill(), ['3 of 6; 3 have no place', 'warn']);
    const { verdict } = await page.evaluate(() => globalThis.handgraft.session.solution);
    assert.match(verdict, /3 more dropped/);
    const { notes } = await settingsOf(page);
    assert.ok(notes.some((note) => /fewer fingers/.test(note)));
    assert.equal(await page.$eval('.told p', (one) => one.textContent), verdict);
    assert.deepEqual(await page.$$eval('.told li', (all) => all.map((one) => one.textContent)), notes);
    await picture(page, 'told');
    // By keys, too.
    await page.focus('.told summary');
    await page.keyboard.press('Enter');
    assert.equal(await page.$eval('.told details', (one) => one.open), false);
    // Those without a place are switched off: then nothing is missing.
    for (const name of ['palm', 'middle', 'little']) {
      await page.evaluate((of) => globalThis.handgraft.session.editing.edit({ kind: 'patch_enabled', patch_enabled: { patch: of, enabled: false } }), name);
      await rest(page);
    }
    await waitText(page, '.pill', /^3 of 3 reached$/);
    assert.equal((await pill())[1], 'good');
    // With none that counts there is no pose to speak well of.
    for (const name of ['thumb', 'index', 'ring']) {
      await page.click(`[data-patch=${name}] .switch`);
      await sleep(500);
    }
    await waitText(page, '.pill', /^no contact counts$/);
    assert.equal((await pill())[1], 'off');
    await waitText(page, '.told p', /^No contact counts/);

    // A finger is held elsewhere: its contact is not out of reach, it is kept away, and the row says what is too far.
    const other = await openSession('human20', 'lemon', 'lemon_6');
    await typed(other, 'drag index_tip to 0 0 0.25\n');
    const second = await openPage(`${address}?session=${other}`, { width: 1280, height: 720 });
    await rest(second);
    await waitText(second, '[data-patch=index] .verdict', /kept away/);
    assert.equal(await second.$eval('[data-patch=index] .verdict', (one) => one.dataset.tone), 'warn');
    await second.click('[data-patch=index] .row');
    await waitText(second, '[data-patch=index] .details', /Within 6 mm on average it counts as reached/);
    await picture(second, 'kept_away');
    return second;
  },

  async 'Sites, normals and points lost are seen when they are asked for; a state is compared with now'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    await page.click('#to-more');
    const details = async () => (await factsOf(page)).details;
    assert.deepEqual(await details(), { sites: 0, normals: 0, lost: 0 });
    for (const text of ['Normals', 'Points lost', 'Sites']) {
      await page.evaluate((name) => [...document.querySelectorAll('#tab-more label')].find((one) => one.textContent === name).querySelector('input').focus(), text);
      await page.keyboard.press('Space');
    }
    const known = await page.evaluate(() => {
      const { session: of } = globalThis.handgraft;
      return {
        sites: of.models.hand.description.sites.length,
        normals: of.solution.patches.reduce((sum, fit) => sum + (fit.hand_W_m.length + fit.object_W_m.length) / 3, 0),
        lost: of.reports.reduce((sum, report) => sum + report.lost.filter((one) => one.ring === 0).length, 0),
      };
    });
    assert.ok(known.sites > 0 && known.normals > 0);
    assert.deepEqual(await details(), known);
    await picture(page, 'details');

    const press = (text) => page.evaluate((name) => [...document.querySelectorAll('#tab-more button')].find((one) => one.textContent === name).click(), text);
    await press('Keep this state');
    await page.waitForFunction(() => globalThis.handgraft.session.settings.snapshots.length === 1, kWaiting);
    await page.click('#to-patches');
    await page.click('[data-patch=index] .switch');
    await waitRevision(page, 1);
    await page.click('#to-more');
    await press('compare');
    await waitText(page, '.differences', /index/);
    return page;
  },

  async 'Another solution and the measured hand are seen beside the pose, and named'(address) {
    const session = await openSession('human20', 'lemon', 'lemon_6');
    const page = await openPage(`${address}?session=${session}`, { width: 1280, height: 720 });
    await rest(page);
    await page.click('#to-more');
    const shells = () => page.$eval('.shells', (element) => element.textContent);
    assert.equal(await shells(), '');
    // Of the pose that is shown the server says the same, link by link.
    const own = await page.evaluate(async () => {
      const { session } = globalThis.handgraft;
      const asked = await session.linkPoses(session.solution.X_WH, session.solution.joint_positions);
      return [asked, session.solution.X_WL].map((all) => all.map((X) => X.p_m));
    });
    own[0].forEach((p, link) => assert.ok(distance(p, own[1][link]) < 1e-9));
    const ghosts = await page.$$('[aria-label="Minima"] .small');
    assert.ok(ghosts.length > 1, 'several solutions are ranked');
    await ghosts[1].click();
    await waitText(page, '.shells', /^solution 2$/);
    // The same as the server's, once that solution is taken.
    const shown = await page.evaluate(() => globalThis.handgraft.view.ghostOf(1).then((all) => all.map((X) => X.elements.slice(12, 15))));
    await picture(page, 'ghost');
    await page.click('[aria-label="Minima"] .line:nth-child(2) .choice');
    await waitRevision(page, 1);
    assert.equal(await shells(), '', 'what is ranked now are others');
    const taken = await page.evaluate(() => globalThis.handgraft.session.solution.X_WL.map((X) => X.p_m));
    const farthest = Math.max(...shown.map((p, link) => distance(p, taken[link])));
    assert.ok(farthest < 0.004, `the ghost lay where the solution is (${farthest} m)`); // solved on from there

    // A simulated hand follows.
    const bridge = start('handgraft-bridge', '--domain', domain, '--session', String(session));
    await waitText(page, '.shells', /measured hand of bridge 1/);
    const names = await page.evaluate(() => globalThis.handgraft.session.measured.hand.names.length);
    assert.equal(names, 20);
    await picture(page, 'measured');
    await page.click('.line[title^="The joints of the hand"] input');
    await waitText(page, '.shells', /^$/);
    await page.click('.line[title^="The joints of the hand"] input');
    await waitText(page, '.shells', /measured/);
    await stop(bridge);
    await waitText(page, '.shells', /^$/);
    return page;
  },

  async 'Who has never seen it is not led astray'(address) {
    const page = await browser.newPage();
    await page.setViewport({ width: 1280, height: 720 });
    await page.goto(address);
    // What is offered first is a grasp that reaches everything.
    await page.waitForSelector('.empty:not([hidden]) button');
    await page.click('.empty button');
    await page.waitForSelector('.part[data-kind=contacts] option');
    // In view, however many sessions there are to choose from.
    assert.ok(await page.$eval('dialog button.main', (one) => {
      const [box, dialog] = [one.getBoundingClientRect(), one.closest('dialog').getBoundingClientRect()];
      return box.top >= dialog.top && box.bottom <= dialog.bottom;
    }));
    await page.click('dialog button.main');
    await page.waitForFunction(() => globalThis.handgraft.session.solution !== null, kWaiting);
    await rest(page);
    assert.match(await page.$eval('.pill', (pill) => pill.dataset.tone), /good/);
    // There is nothing to undo yet: not even the solve.
    assert.equal(await page.$eval('[aria-label^=Undo]', (one) => one.disabled), true);
    await page.focus('canvas');
    await page.keyboard.down('Control');
    await page.keyboard.press('z');
    await page.keyboard.up('Control');
    await sleep(300);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.state.revision), 0);
    // A menu goes away by itself, by a press elsewhere and by Escape.
    const isOpen = () => page.$eval('details.menu', (menu) => menu.open);
    await page.click('summary.icon');
    assert.equal(await isOpen(), true);
    await page.keyboard.press('Escape');
    assert.equal(await isOpen(), false);
    await page.click('summary.icon');
    await page.click('h1');
    assert.equal(await isOpen(), false);
    // The hand that does not go with the contacts is offered those that do.
    await page.click('header > button:not(.icon)');
    await page.waitForSelector('dialog[open] .choice');
    await page.select('.part[data-kind=hand] select', 'barrett8');
    assert.equal(await page.$eval('.part[data-kind=contacts] select', (one) => one.value), 'lemon_3');
    await page.select('.part[data-kind=hand] select', 'human20');
    assert.equal(await page.$eval('.part[data-kind=contacts] select', (one) => one.value), 'lemon_6');
    await page.click('dialog .end button');
    // Nothing is cut off, however narrow it is.
    for (const width of [1280, 820, 390]) {
      await page.setViewport({ width, height: 800 });
      const cut = await page.$$eval('header button, header summary, .tabs button, .modes button', (all) =>
        all.filter((one) => one.checkVisibility() && (one.getBoundingClientRect().right > innerWidth || one.getBoundingClientRect().left < 0)).map((one) => one.ariaLabel ?? one.textContent));
      assert.deepEqual(cut, [], `at ${width} pixels`);
    }
    return page;
  },
};

await runTests(tests);
