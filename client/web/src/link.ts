// The gateway, or the data that an exported page brings along.

import { liveAddress, takeEarly } from './live';
import { readModel, type EditBody, type EditTime, type FramesNews, type Model, type ModelSummary, type MotionClock, type MotionFrames, type PoseSolution, type SessionState } from './wire';

export class Refusal extends Error {
  constructor(
    readonly code: string,
    message: string,
  ) {
    super(message);
  }
}

export interface PageInfo {
  page: number;
  may_edit: boolean;
  sessions: number[];
}

/** What a link tells without being asked. */
export interface Listener {
  onWelcome(page: number, mayEdit: boolean): void;
  onLink(isUp: boolean): void;
  onServer(isHeard: boolean): void;
  onState(session: number, state: SessionState, isOurs: boolean, page: number): void;
  onPose(session: number, solution: PoseSolution): void;
  onFrames(session: number, news: FramesNews): void;
  onClock(session: number, clock: MotionClock, age_s: number): void;
  onPages(pages: PageInfo[]): void;
  onMoved(from: number, to: number): void;
  onLost(session: number, message: string): void;
  onMeasured(session: number, measured: Measured): void;
}

/** The joints of a hand that follows a session, as its bridge measures them. */
export interface Measured {
  bridge: number;
  names: string[];
  positions: number[];
}

export interface Link {
  readonly isLive: boolean;
  start(listener: Listener): void;
  ask<Reply>(body: Record<string, unknown>): Promise<Reply>;
  /** `when`: about which time of a motion; `base`: refused if the session has moved on from there. */
  edit(session: number, body: EditBody, when?: EditTime | null, base?: number): Promise<{ revision: number; message: string }>;
  describe<Description>(kind: string, name: string): Promise<Model<Description>>;
  follow(session: number): Promise<SessionState>;
  /** It is not shown any more. */
  leave(session: number): void;
  /** A file of those that belong together, by its path among them. */
  give(group: number, path: string, file: Blob, sent: (bytes: number) => void): Promise<void>;
  /** Has the server read a model of what was given. */
  load(group: number, kind: string, main: string, object: string, units: string): Promise<ModelSummary>;
  forget(group: number): void;
}

interface Waiting {
  resolve(reply: unknown): void;
  reject(error: Error): void;
}

const kFirstPause_ms = 250;
const kLongestPause_ms = 4000;
const kHeartbeat_ms = 2000; // three without an answer, and the connection is gone
const kPart = 1 << 20; // bytes of a file in one message
const kPace_ms = 10; // between messages of many files: the gateway takes so many a second

/** The length of a head in 4 bytes, the head, and what it is about. */
function frameOf(text: string, bytes: Uint8Array): Uint8Array {
  const head = new TextEncoder().encode(text);
  const frame = new Uint8Array(4 + head.length + bytes.length);
  new DataView(frame.buffer).setUint32(0, head.length, true);
  frame.set(head, 4);
  frame.set(bytes, 4 + head.length);
  return frame;
}

/** A WebSocket that is opened again whenever it goes. */
export class LiveLink implements Link {
  readonly isLive = true;
  private socket: WebSocket | null = null;
  private listener: Listener | null = null;
  private readonly waiting = new Map<number, Waiting>();
  private last = 0;
  private pause_ms = kFirstPause_ms;
  private timer = 0;
  private heard_ms = 0;
  /** What was asked before the page was read, by request, and what came of it by now. */
  private readonly early = new Map<string, number>();
  private readonly earlyReplies = new Map<number, (one: Waiting) => void>();

  constructor(private readonly address: string) {}

  start(listener: Listener): void {
    this.listener = listener;
    this.open();
    setInterval(() => this.listen(), kHeartbeat_ms);
    // After a sleep, or a change of networks: at once.
    window.addEventListener('online', () => this.hurry());
    // A browser may keep a page that was left, for going back to it: it is not here meanwhile.
    window.addEventListener('pagehide', () => this.socket?.close());
    window.addEventListener('pageshow', () => this.hurry());
    document.addEventListener('visibilitychange', () => {
      if (!document.hidden) this.hurry();
    });
  }

  async ask<Reply>(body: Record<string, unknown>): Promise<Reply> {
    const reply = (await this.send({ do: 'ask', body })) as { body: Record<string, unknown> };
    const kind = reply.body['kind'] as string;
    const member = Object.keys(reply.body).find((key) => key !== 'kind');
    return (member === undefined ? kind : reply.body[member]) as Reply;
  }

  async edit(session: number, body: EditBody, when: EditTime | null = null, base = 0): Promise<{ revision: number; message: string }> {
    return (await this.send({ do: 'edit', session, base_revision: base, body, when })) as { revision: number; message: string };
  }

  async describe<Description>(kind: string, name: string): Promise<Model<Description>> {
    return (await this.once(`describe ${kind} ${name}`, { do: 'describe', kind, name })) as Model<Description>;
  }

  async follow(session: number): Promise<SessionState> {
    try {
      const reply = (await this.once(`follow ${session}`, { do: 'follow', session })) as { session: SessionState };
      this.nameEarly(reply.session);
      return reply.session;
    } catch (error) {
      this.early.clear(); // nor do its models come unasked
      throw error;
    }
  }

  leave(session: number): void {
    this.send({ do: 'unfollow', session }).catch(() => undefined); // with the connection it goes anyway
  }

  async give(group: number, path: string, file: Blob, sent: (bytes: number) => void): Promise<void> {
    for (let offset = 0; offset === 0 || offset < file.size; offset += kPart) {
      const begun = performance.now();
      const bytes = await file.slice(offset, offset + kPart).arrayBuffer();
      const head = { do: 'put', group, path, total_bytes: file.size, offset };
      await this.send(head, new Uint8Array(bytes));
      sent(Math.min(file.size, offset + kPart));
      const rest = kPace_ms - (performance.now() - begun);
      if (rest > 0) await new Promise((resolve) => setTimeout(resolve, rest));
    }
  }

  async load(group: number, kind: string, main: string, object: string, units: string): Promise<ModelSummary> {
    return ((await this.send({ do: 'load', group, kind, main, object, units })) as { model: ModelSummary }).model;
  }

  forget(group: number): void {
    this.send({ do: 'drop', group }).catch(() => undefined); // with the connection it goes anyway
  }

  private open(): void {
    clearTimeout(this.timer);
    const early = takeEarly();
    const socket = early?.socket ?? new WebSocket(this.address);
    socket.binaryType = 'arraybuffer';
    socket.onmessage = (event) => {
      this.heard_ms = performance.now();
      this.handle(event.data as string | ArrayBuffer);
    };
    socket.onclose = () => this.closed(socket);
    this.socket = socket;
    this.heard_ms = performance.now();
    if (early === null) return;
    if (early.session > 0) {
      // As the gateway numbers what it sends of a session that an address names.
      [`follow ${early.session}`, 'hand', 'object', 'patches'].forEach((what, i) => this.early.set(what, i + 1));
      this.last = this.early.size;
    }
    for (const data of early.heard) this.handle(data);
  }

  private closed(socket: WebSocket): void {
    if (socket !== this.socket) return;
    this.socket = null;
    for (const one of this.waiting.values()) one.reject(new Refusal('no_link', 'the connection is gone'));
    this.waiting.clear();
    this.early.clear();
    this.earlyReplies.clear();
    this.listener?.onLink(false);
    this.timer = window.setTimeout(() => this.open(), this.pause_ms);
    this.pause_ms = Math.min(2 * this.pause_ms, kLongestPause_ms);
  }

  private hurry(): void {
    this.pause_ms = kFirstPause_ms;
    if (this.socket === null) this.open();
    else this.listen();
  }

  /** A connection that died without a word is noticed, too. */
  private listen(): void {
    const socket = this.socket;
    if (socket === null) return;
    if (performance.now() - this.heard_ms > 3 * kHeartbeat_ms) {
      socket.close();
      this.closed(socket);
    } else if (socket.readyState === WebSocket.OPEN) {
      socket.send(JSON.stringify({ id: ++this.last, do: 'ping' }));
    }
  }

  private send(message: Record<string, unknown>, bytes?: Uint8Array): Promise<unknown> {
    const socket = this.socket;
    if (socket === null || socket.readyState !== WebSocket.OPEN) {
      return Promise.reject(new Refusal('no_link', 'there is no connection'));
    }
    const id = ++this.last;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      const text = JSON.stringify({ id, ...message });
      socket.send(bytes === undefined ? text : frameOf(text, bytes));
    });
  }

  /** The models that the gateway sends unasked are those of that session. */
  private nameEarly(state: SessionState): void {
    for (const kind of ['hand', 'object', 'patches'] as const) {
      const id = this.early.get(kind);
      if (id === undefined) continue;
      this.early.delete(kind);
      const named = kind !== 'patches' ? kind : state.motion !== '' ? 'motion' : 'contacts';
      this.early.set(`describe ${named} ${state[named]}`, id);
    }
  }

  /** Asks, unless that was done before the page was read. */
  private once(what: string, message: Record<string, unknown>): Promise<unknown> {
    const id = this.early.get(what);
    if (id === undefined) return this.send(message);
    this.early.delete(what);
    return new Promise((resolve, reject) => {
      const settle = this.earlyReplies.get(id);
      this.earlyReplies.delete(id);
      if (settle !== undefined) settle({ resolve, reject });
      else this.waiting.set(id, { resolve, reject });
    });
  }

  private settle(id: number, settle: (one: Waiting) => void): void {
    const one = this.waiting.get(id);
    this.waiting.delete(id);
    if (one !== undefined) settle(one);
    else if ([...this.early.values()].includes(id)) this.earlyReplies.set(id, settle);
  }

  private handle(data: string | ArrayBuffer): void {
    if (typeof data !== 'string') {
      const model = readModel(data);
      this.settle(model.request, (one) => one.resolve(model));
      return;
    }
    const message = JSON.parse(data);
    if (message.reply !== undefined) {
      this.settle(message.reply, (one) => {
        if (message.error) one.reject(new Refusal(message.error.code, message.error.message));
        else one.resolve(message);
      });
      return;
    }
    const to = this.listener;
    if (to === null) return;
    switch (message.event) {
      case 'welcome':
        this.pause_ms = kFirstPause_ms;
        to.onServer(message.server_is_heard);
        to.onWelcome(message.page, message.may_edit);
        to.onLink(true);
        break;
      case 'server':
        to.onServer(message.is_heard);
        break;
      case 'state':
        to.onState(message.session, message.state, message.is_ours, message.page);
        break;
      case 'pose':
        to.onPose(message.session, message.solution);
        break;
      case 'frames':
        to.onFrames(message.session, message);
        break;
      case 'clock':
        to.onClock(message.session, message.clock, message.age_s);
        break;
      case 'pages':
        to.onPages(message.pages);
        break;
      case 'moved':
        to.onMoved(message.from, message.to);
        break;
      case 'measured':
        to.onMeasured(message.session, message);
        break;
      case 'lost':
        to.onLost(message.session, message.message);
        break;
    }
  }
}

/** All that an exported page shows (client/gateway/page_file.h). */
export interface PageData {
  state: SessionState;
  solution: PoseSolution | null; // of a motion: its frames instead
  settings: unknown;
  transfer: unknown;
  models: Record<string, string>; // base64 of model frames, by kind
  motion_frames?: MotionFrames; // all that are shown
  past?: { revision: number; edit: string; solution: PoseSolution }[];
}

export class FileLink implements Link {
  readonly isLive = false;

  constructor(readonly data: PageData) {}

  start(listener: Listener): void {
    const id = this.data.state.session_id;
    listener.onWelcome(0, false);
    listener.onLink(true);
    queueMicrotask(() => {
      listener.onState(id, this.data.state, false, 0);
      if (this.data.solution !== null) listener.onPose(id, this.data.solution);
    });
  }

  async ask<Reply>(body: Record<string, unknown>): Promise<Reply> {
    if (body['kind'] === 'session_settings') return this.data.settings as Reply;
    if (body['kind'] === 'transfer') return this.data.transfer as Reply;
    if (body['kind'] === 'motion_frames' && this.data.motion_frames !== undefined) {
      const { first } = body['motion_frames'] as { first: number };
      const { frames, ...rest } = this.data.motion_frames;
      return { ...rest, frames: first === 0 ? frames : [] } as Reply;
    }
    throw new Refusal('unsupported', 'this page is a file, without a server');
  }

  edit(): Promise<{ revision: number; message: string }> {
    return Promise.reject(new Refusal('not_permitted', 'this page is a file, without a server'));
  }

  async describe<Description>(kind: string): Promise<Model<Description>> {
    const text = atob(this.data.models[kind] ?? '');
    return readModel(Uint8Array.from(text, (letter) => letter.charCodeAt(0)).buffer);
  }

  async follow(): Promise<SessionState> {
    return this.data.state;
  }

  leave(): void {
    // Nobody counts who looks.
  }

  give(): Promise<void> {
    return Promise.reject(new Refusal('not_permitted', 'this page is a file, without a server'));
  }

  load(): Promise<ModelSummary> {
    return Promise.reject(new Refusal('not_permitted', 'this page is a file, without a server'));
  }

  forget(): void {
    // Nothing was given.
  }
}

/** The exported page's data, else the gateway that the page came from. */
export function findLink(): Link {
  const data = document.getElementById('handgraft-data')?.textContent;
  if (data) return new FileLink(JSON.parse(data) as PageData);
  return new LiveLink(liveAddress());
}
