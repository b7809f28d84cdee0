// trouble_page_test.mjs BIN PACKAGES PICTURES DOMAIN [NAME]: strangers that mean harm, a laptop that sleeps, a network that is gone. As
// page_test.mjs.

import assert from 'node:assert/strict';
import { randomBytes } from 'node:crypto';
import { readdirSync, readFileSync } from 'node:fs';
import http from 'node:http';
import net from 'node:net';
import { browser, dotOf, dragBy, factsOf, kPatience_ms, kWaiting, openPage, openSession, rest, runTests, serverPose, settingsOf, sleep, startView, stop, typed, waitRevision } from './browser.mjs';

// === A stranger: as much of a WebSocket as harm takes

class Stranger {
  constructor(port) {
    this.socket = net.connect(port, '127.0.0.1');
    this.socket.on('error', () => undefined);
    this.heard = Buffer.alloc(0);
    this.gone = new Promise((resolve) => this.socket.on('close', resolve));
    this.socket.on('data', (bytes) => {
      this.heard = Buffer.concat([this.heard, bytes]);
    });
    this.port = port;
  }

  /** The status line. */
  async join(path = '/live', origin = `http://127.0.0.1:${this.port}`) {
    this.socket.write(
      `GET ${path} HTTP/1.1\r\nHost: 127.0.0.1:${this.port}\r\nOrigin: ${origin}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n` +
        `Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: ${randomBytes(16).toString('base64')}\r\n\r\n`,
    );
    for (let waited = 0; !this.heard.includes('\r\n') && waited < kPatience_ms; waited += 10) await sleep(10);
    const end = this.heard.indexOf('\r\n\r\n');
    const status = this.heard.subarray(0, this.heard.indexOf('\r\n')).toString();
    this.heard = this.heard.subarray(end + 4);
    return status;
  }

  static frame(text, length = Buffer.byteLength(text)) {
    const head = length < 126 ? Buffer.from([0x81, 0x80 | length]) : Buffer.alloc(10);
    if (length >= 126) {
      head[0] = 0x81;
      head[1] = 0x80 | 127;
      head.writeBigUInt64BE(BigInt(length), 2);
    }
    return Buffer.concat([head, Buffer.alloc(4), Buffer.from(text)]); // a mask of zeros
  }

  /** The code that the connection is closed with; null: it was cut. */
  async code() {
    await Promise.race([this.gone, sleep(kPatience_ms)]);
    for (let at = 0; at + 1 < this.heard.length; ) {
      const kind = this.heard[at] & 0x0f;
      let length = this.heard[at + 1] & 0x7f;
      let begin = at + 2;
      if (length === 126) {
        length = this.heard.readUInt16BE(begin);
        begin += 2;
      } else if (length === 127) {
        length = Number(this.heard.readBigUInt64BE(begin));
        begin += 8;
      }
      if (kind === 8) return this.heard.readUInt16BE(begin);
      at = begin + length;
    }
    return null;
  }
}

// === A network between page and gateway that may go

async function startNetwork(port) {
  const sockets = new Set();
  let isGone = false;
  const server = net.createServer((from) => {
    const to = net.connect(port, '127.0.0.1');
    for (const [a, b] of [[from, to], [to, from]]) {
      sockets.add(a);
      a.on('data', (bytes) => b.write(bytes));
      a.on('error', () => undefined);
      a.on('close', () => {
        sockets.delete(a);
        b.destroy();
      });
      if (isGone) a.pause();
    }
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {
    port: server.address().port,
    /** Nothing gets through, and nobody is told. */
    set(gone) {
      isGone = gone;
      for (const one of sockets) gone ? one.pause() : one.resume();
    },
    stop() {
      for (const one of sockets) one.destroy();
      server.close();
    },
  };
}

/** A process and all that it started. */
function family(pid) {
  const parents = new Map();
  for (const entry of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
    try {
      parents.set(Number(entry), Number(/\) \S (\d+)/.exec(readFileSync(`/proc/${entry}/stat`, 'utf8'))[1]));
    } catch {
      // It has ended.
    }
  }
  const all = [pid];
  for (let i = 0; i < all.length; ++i) for (const [child, parent] of parents) if (parent === all[i]) all.push(child);
  return all;
}

/// To those that are still there: a browser ends some of its processes by itself, and one signal
/// that met nobody would leave the others stopped for good.
function signal(pids, which) {
  for (const pid of pids) {
    try {
      process.kill(pid, which);
    } catch (error) {
      if (error.code !== 'ESRCH') throw error;
    }
  }
}

async function runsOn(page) {
  const before = (await factsOf(page)).revision;
  await dragBy(page, await dotOf(page, 'thumb', 'hand'), 10, 8);
  await waitRevision(page, before + 1);
}

const tests = {
  async 'A malicious page is refused with a clear code, and others notice nothing'(address) {
    const session = await openSession('human20');
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    const { port } = new URL(address);

    // A page of another origin, in the same browser.
    const elsewhere = http.createServer((_, response) => response.end('<!doctype html>')).listen(0);
    const other = await browser.newPage();
    await other.goto(`http://127.0.0.1:${elsewhere.address().port}/`);
    const joined = await other.evaluate((to) => new Promise((resolve) => {
      const socket = new WebSocket(to);
      socket.onopen = () => resolve(true);
      socket.onerror = () => resolve(false);
    }), `ws://127.0.0.1:${port}/live`);
    assert.equal(joined, false);
    await other.close();
    elsewhere.close();
    assert.match(await new Stranger(port).join('/live', 'http://attacker.example'), /403/);

    // 10,000 messages at once from each of several, and nonsense, while the page is edited.
    await page.bringToFront();
    const nonsense = ['{"do":', '[]', '{"id":-1,"do":"edit"}', '{"do":"ask","body":{"kind":"close_session","session":{"session_id":1}}}', '{"do":"describe","kind":"hand","name":"../../etc/passwd"}'];
    const talkers = [];
    for (let i = 0; i < 5; ++i) {
      const talker = new Stranger(port);
      assert.match(await talker.join(), /101/);
      talker.socket.write(Buffer.concat(Array.from({ length: 10000 }, (_, k) => Stranger.frame(nonsense[k % nonsense.length]))));
      talkers.push(talker);
    }
    // One message of 100 MB.
    const large = new Stranger(port);
    assert.match(await large.join(), /101/);
    large.socket.write(Stranger.frame('x'.repeat(1000), 100_000_000));
    await runsOn(page);
    for (const talker of talkers) assert.equal(await talker.code(), 1008);
    assert.equal(await large.code(), 1009);

    // 200 connections.
    const crowd = Array.from({ length: 200 }, () => new Stranger(port));
    const answers = await Promise.all(crowd.map((one) => one.join()));
    assert.ok(answers.some((status) => /503/.test(status)));
    assert.ok(answers.every((status) => /101|503/.test(status)), 'nothing but those two');
    await runsOn(page);
    for (const one of crowd) one.socket.destroy();

    // Nothing of the machine, by whatever path.
    for (const path of ['/../../../etc/passwd', '/%2e%2e/etc/passwd', '//etc/passwd']) {
      const answer = await new Promise((resolve) => http.get({ port, path, host: '127.0.0.1' }, resolve));
      assert.equal(answer.statusCode, 404);
      answer.resume();
    }
    await runsOn(page);
    assert.equal((await serverPose(session)).revision, (await factsOf(page)).revision);
    assert.equal(await page.$eval('.banner', (element) => element.hidden), true);
    return page;
  },

  async 'Without a token nobody joins where one is needed'() {
    const session = await openSession();
    const view = await startView(String(session), '--address', '0.0.0.0');
    const { port, hash } = new URL(view.address);
    for (const path of ['/live', '/live?token=', '/live?token=0123456789abcdef0123456789abcdef']) {
      assert.match(await new Stranger(port).join(path), /401/);
    }
    const page = await openPage(`http://127.0.0.1:${port}/?session=${session}${hash}`);
    await rest(page);
    await stop(view.process);
    return page;
  },

  async 'A laptop that slept for a minute goes on where others are by then'(address) {
    const session = await openSession();
    const page = await openPage(`${address}?session=${session}`);
    await rest(page);
    const asleep = family(browser.process().pid);
    signal(asleep, 'SIGSTOP');
    await typed(session, 'disable index\n');
    await sleep(60000);
    signal(asleep, 'SIGCONT');
    await waitRevision(page, 1);
    await page.waitForSelector('.banner[hidden]', { timeout: kPatience_ms });
    assert.equal((await settingsOf(page)).patches.find((one) => one.name === 'index').enabled, false);
    await runsOn(page);
    return page;
  },

  async 'Wi-Fi that is gone for ten seconds is told, and the page goes on where it stood'() {
    const session = await openSession();
    const view = await startView(String(session));
    const network = await startNetwork(Number(new URL(view.address).port));
    const page = await openPage(`http://127.0.0.1:${network.port}/?session=${session}`);
    await rest(page);
    await runsOn(page);
    const before = await factsOf(page);
    network.set(true);
    const gone = Date.now();
    await page.waitForSelector('.banner:not([hidden])', { timeout: 10000 });
    // What is shown stays.
    assert.deepEqual((await factsOf(page)).links, before.links);
    await sleep(Math.max(0, 10000 - (Date.now() - gone)));
    network.set(false);
    await page.waitForSelector('.banner[hidden]', { timeout: kPatience_ms });
    await page.waitForFunction(() => globalThis.handgraft.session.solution?.is_diagnosed, kWaiting);
    await rest(page);
    assert.equal((await factsOf(page)).revision, before.revision);
    await runsOn(page);
    assert.equal((await serverPose(session)).revision, (await factsOf(page)).revision);
    network.stop();
    await stop(view.process);
    return page;
  },
};

await runTests(tests);
