// files_page_test.mjs BIN PACKAGES PICTURES DOMAIN [NAME]: hands, objects and contacts given to the page as files, by real
// drops and real file choosers. As page_test.mjs.

import assert from 'node:assert/strict';
import { cpSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { browser, downloads, handgraft, kWaiting, openPage, openSession, packages, picture, rest, runTests, sleep, startView, stop, waitText } from './browser.mjs';

const { zipSync } = createRequire(resolve(packages, 'package.json'))('fflate');
const kModels = fileURLToPath(new URL('../../../server/models/', import.meta.url));

/** A box as OBJ, of those half sizes in m. */
function boxText(x, y, z) {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => `v ${i & 1 ? x : -x} ${i & 2 ? y : -y} ${i & 4 ? z : -z}`);
  const faces = ['1 3 4', '1 4 2', '5 6 8', '5 8 7', '1 2 6', '1 6 5', '3 7 8', '3 8 4', '1 5 7', '1 7 3', '2 4 8', '2 8 6'];
  return [...corners, ...faces.map((face) => `f ${face}`)].join('\n') + '\n';
}

/** A hand whose files lie as in ROS packages: urdf/ and meshes/. */
function handFolder(name, mesh = `package://${name}/meshes/knob.obj`) {
  const folder = join(downloads, name);
  mkdirSync(join(folder, 'urdf'), { recursive: true });
  mkdirSync(join(folder, 'meshes'), { recursive: true });
  const urdf = readFileSync(join(kModels, 'hands/barrett8/barrett8.urdf'), 'utf8')
    .replace('<box size="0.014000 0.020000 0.050000"/>', `<mesh filename="${mesh}"/>`)
    .replace('name="barrett8"', `name="${name}"`);
  writeFileSync(join(folder, 'urdf', `${name}.urdf`), urdf);
  writeFileSync(join(folder, 'meshes/knob.obj'), boxText(0.007, 0.01, 0.025));
  writeFileSync(join(folder, 'README.txt'), 'of no use to anybody');
  return { folder, urdf };
}

/** The page, and no session on it. */
async function openEmpty(address) {
  const page = await browser.newPage();
  await page.setViewport({ width: 1280, height: 720 });
  page.on('pageerror', (error) => {
    console.log('page error:', error.stack ?? error.message);
    page.broken = error;
  });
  await page.goto(address);
  await page.waitForFunction(() => globalThis.handgraft?.session.page > 0, kWaiting);
  return page;
}

/** Files from the desktop, dragged over the page and let go. */
async function drop(page, files) {
  const client = await page.createCDPSession();
  const data = { items: [], files, dragOperationsMask: 1 };
  for (const type of ['dragEnter', 'dragOver', 'drop']) {
    await client.send('Input.dispatchDragEvent', { type, x: 300, y: 300, data });
    if (type === 'dragOver') await picture(page, 'drop');
  }
  await client.detach();
}

const note = (kind) => `.part[data-kind=${kind}] .note`;
const textAt = (page, selector) => page.$eval(selector, (element) => element.textContent);

const tests = {
  async 'A hand’s folder, a mesh and contacts are dropped, and grasp each other'(address) {
    const page = await openEmpty(address);
    const { folder } = handFolder('my_barrett');
    const lemon = join(downloads, 'my_lemon.obj');
    cpSync(join(kModels, 'objects/lemon.obj'), lemon);
    const contacts = join(downloads, 'my_lemon_6.json');
    cpSync(join(kModels, 'contacts/lemon_6.json'), contacts);
    await drop(page, [folder, lemon, contacts]);
    for (const kind of ['hand', 'object', 'contacts']) await waitText(page, note(kind), /^✓/);
    assert.match(await textAt(page, note('hand')), /my_barrett\.urdf: .*8 joints/);
    await picture(page, 'dropped');
    await page.click('dialog button.main');
    await page.waitForFunction(() => globalThis.handgraft.session.state !== null, kWaiting);
    await rest(page);
    const state = await page.evaluate(() => globalThis.handgraft.session.state);
    assert.deepEqual([state.hand, state.object, state.contacts], ['my_barrett', 'my_lemon', 'my_lemon_6']);
    assert.match(await handgraft('sessions'), /my_barrett/);

    // Another hand of that name is told apart, and the first one stays what it was.
    const urdf = join(folder, 'urdf/my_barrett.urdf');
    writeFileSync(urdf, readFileSync(urdf, 'utf8').replace('upper="2.440000"', 'upper="2.000000"'));
    await drop(page, [folder]);
    await page.waitForFunction(() => /^my_barrett-[0-9a-f]{8}$/.test(document.querySelector('.part[data-kind=hand] select').value), kWaiting);
    await page.keyboard.press('Escape');
    return page;
  },

  async 'A zip is chosen by keys alone'(address) {
    const page = await openEmpty(address);
    const { urdf } = handFolder('zipped', '../meshes/knob.obj');
    const zip = join(downloads, 'zipped.zip');
    const text = new TextEncoder();
    writeFileSync(zip, zipSync({ 'urdf/zipped.urdf': text.encode(urdf), 'meshes/knob.obj': text.encode(boxText(0.007, 0.01, 0.025)), '.git/config': text.encode('x') }));
    await page.focus('.empty button');
    await page.keyboard.press('Enter');
    await page.waitForSelector('.part[data-kind=contacts] option');
    await page.focus('[aria-label="File of the hand"]');
    const chosen = page.waitForFileChooser();
    await sleep(300); // the browser's own dialog is held back from then on
    await page.keyboard.press('Enter');
    await (await chosen).accept([zip]);
    await waitText(page, note('hand'), /^✓ zipped\/urdf\/zipped\.urdf/);
    assert.equal(await page.$eval('.part[data-kind=hand] select', (one) => one.value), 'zipped');
    return page;
  },

  async 'What is wrong is told where it belongs, and which value'(address) {
    const page = await openEmpty(address);
    const text = new TextEncoder();
    const { folder, urdf } = handFolder('wrong', 'package://wrong/meshes/thumb.obj');
    await drop(page, [folder]);
    await waitText(page, note('hand'), /wrong\/urdf\/wrong\.urdf: '?.*thumb\.obj.*no such file/);
    assert.equal(await page.$eval(note('hand'), (one) => one.dataset.tone), 'bad');
    assert.equal((await textAt(page, note('hand'))).includes('/tmp'), false, 'no path of the gateway’s machine is told');
    await picture(page, 'missing');

    // What the server finds: a joint's limits, by its own words.
    writeFileSync(join(folder, 'urdf/wrong.urdf'), urdf.replace('thumb.obj', 'knob.obj').replace('upper="2.440000"', 'upper="-2.440000"'));
    await drop(page, [folder]);
    await waitText(page, note('hand'), /thumb_proximal_flex/);

    // Paths that lead out of a zip.
    const zip = join(downloads, 'evil.zip');
    writeFileSync(zip, zipSync({ 'urdf/evil.urdf': text.encode(urdf), '../../evil.obj': text.encode('v 0 0 0') }));
    await drop(page, [zip]);
    await waitText(page, 'dialog > .note', /evil\.zip: “\.\.\/\.\.\/evil\.obj” leads out of it/);
    writeFileSync(zip, 'no zip at all');
    await drop(page, [zip]);
    await waitText(page, 'dialog > .note', /cannot be unpacked/);

    // Files of the machine that serves the page are not to be had.
    for (const path of ['file:///etc/passwd.stl', '/etc/hostname', '../../../../../../etc/hostname']) {
      writeFileSync(join(folder, 'urdf/wrong.urdf'), urdf.replace('package://wrong/meshes/thumb.obj', path));
      await drop(page, [folder]);
      await waitText(page, note('hand'), path.includes('..') ? /leads out of the files/ : /relative paths/);
    }

    // Contacts that their object has no place for: which value, and what is permitted.
    const contacts = join(downloads, 'broken.json');
    writeFileSync(contacts, readFileSync(join(kModels, 'contacts/lemon_6.json'), 'utf8').replace(/"vertex": \d+/, '"vertex": 999999'));
    await drop(page, [contacts]);
    await waitText(page, note('contacts'), /broken\.json.*999999.*3615/);
    assert.equal(await page.$eval(note('contacts'), (one) => one.dataset.tone), 'bad');

    // What was refused is not replaced by what was chosen before it, behind the user's back.
    const mayGrasp = () => page.$eval('dialog button.main', (one) => !one.disabled);
    assert.deepEqual(await page.$$eval('.part select:first-of-type[required]', (all) => all.map((one) => one.value === '')), [true, false, true]);
    assert.equal(await mayGrasp(), false);
    await page.select('.part[data-kind=hand] select', 'human20');
    assert.equal(await mayGrasp(), false);
    await page.select('.part[data-kind=contacts] select', 'lemon_6');
    assert.equal(await mayGrasp(), true);
    assert.equal(await page.$eval(note('hand'), (one) => one.hidden), true);
    return page;
  },

  async 'A session that was saved is opened, dropped or chosen, and told from the others'(address) {
    const session = await openSession();
    const file = join(downloads, 'barrett8_lemon.session.json');
    await handgraft('session', 'save', String(session), file);
    const page = await openEmpty(address);
    const shown = (before) => page.waitForFunction((old) => globalThis.handgraft.session.state !== null && globalThis.handgraft.session.id !== old, kWaiting, before);
    await drop(page, [file]);
    await shown(0);
    await rest(page);
    const first = await page.evaluate(() => globalThis.handgraft.session.id);
    assert.notEqual(first, session);
    assert.equal(await page.evaluate(() => globalThis.handgraft.session.state.contacts), 'lemon_6');
    assert.equal(await page.$('dialog[open]'), null);

    await page.click('header > button:not(.icon)');
    await page.waitForSelector('dialog[open] .choice');
    assert.match(await textAt(page, 'dialog .list'), /barrett8 grasps lemon by lemon_6/);
    const chooser = page.waitForFileChooser();
    await sleep(300);
    await page.evaluate(() => [...document.querySelectorAll('dialog button')].find((one) => one.textContent === 'Saved session…').click());
    await (await chooser).accept([file]);
    await shown(first);
    await rest(page);

    // One that is none any more.
    writeFileSync(file, readFileSync(file, 'utf8').replace('"hand":"barrett8"', '"hand":"nobody"'));
    await drop(page, [file]);
    await waitText(page, 'dialog > .note', /nobody/);
    await page.keyboard.press('Escape');
    return page;
  },

  async 'On a phone nothing lies over what is chosen'(address) {
    const page = await openEmpty(address);
    await page.setViewport({ width: 390, height: 844 });
    await page.click('.empty button');
    await page.waitForSelector('.part[data-kind=contacts] option');
    const overlaps = await page.$$eval('.part', (parts) =>
      parts.filter((part) => {
        const select = part.querySelector('select').getBoundingClientRect();
        return [...part.querySelectorAll('button')].some((one) => {
          const box = one.getBoundingClientRect();
          return box.width > 0 && box.left < select.right && box.right > select.left && box.top < select.bottom && box.bottom > select.top;
        });
      }).length);
    await picture(page, 'open_phone');
    assert.equal(overlaps, 0);
    return page;
  },

  async 'An object in millimetres is asked about'(address) {
    const page = await openEmpty(address);
    const file = join(downloads, 'big_box.obj');
    writeFileSync(file, boxText(33, 20, 80));
    await drop(page, [file]);
    await waitText(page, note('object'), /say which/);
    await picture(page, 'units');
    await page.click('.part[data-kind=object] .line:not([hidden]) > select + button');
    await waitText(page, note('object'), /^✓/);
    return page;
  },

  async 'A link for looking loads nothing'() {
    const session = await openSession();
    const view = await startView(String(session), '--read-only');
    const page = await openPage(view.address);
    await drop(page, [handFolder('unwanted').folder]);
    await waitText(page, '.toasts', /for looking/);
    assert.equal(await page.$('dialog[open]'), null);
    // Nor by a page that was changed.
    const code = await page.evaluate(async () => {
      const { link } = globalThis.handgraft.session;
      try {
        await link.give(1, 'a.obj', new Blob(['v 0 0 0']), () => undefined);
        return '';
      } catch (error) {
        return error.code;
      }
    });
    assert.equal(code, 'not_permitted');
    assert.equal((await handgraft('models')).includes('unwanted'), false);
    await stop(view.process);
    return page;
  },
};

await runTests(tests);
