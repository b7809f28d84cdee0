// A stream of edits from one drag: the newest wins.

import type { EditBody } from './wire';

const kFastest_ms = 25; // between two edits of one drag

export class Drag {
  private next: EditBody | (() => EditBody) | null = null;
  private inFlight = 0;
  private sent_ms = -Infinity;
  private timer = 0;
  private done = false;
  private first = Infinity;
  private last = -1;

  constructor(
    private readonly send: (body: EditBody) => Promise<number>,
    private readonly most: number, // edits that are not answered yet
    private readonly finished: (from: number, to: number) => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  /** A function is called when its edit is sent: for what adds up. */
  move(body: EditBody | (() => EditBody)): void {
    this.next = body;
    this.pump();
  }

  /** What was moved last still counts. */
  end(): void {
    this.done = true;
    this.pump();
  }

  /** Sends the newest, unless too many are on their way or the last one has only just been sent. */
  private pump(): void {
    if (this.next === null) {
      if (this.done && this.inFlight === 0) this.close();
      return;
    }
    if (this.inFlight >= this.most || this.timer !== 0) return;
    const rest = kFastest_ms - (performance.now() - this.sent_ms);
    if (rest > 0) {
      this.timer = window.setTimeout(() => {
        this.timer = 0;
        this.pump();
      }, rest);
      return;
    }
    const body = typeof this.next === 'function' ? this.next() : this.next;
    this.next = null;
    this.sent_ms = performance.now();
    void this.run(body);
  }

  private async run(body: EditBody): Promise<void> {
    ++this.inFlight;
    try {
      const revision = await this.send(body);
      this.first = Math.min(this.first, revision - 1);
      this.last = Math.max(this.last, revision);
    } catch (error) {
      this.failed(error);
      this.next = null;
    }
    --this.inFlight;
    this.pump();
  }

  private close(): void {
    this.done = false;
    this.finished(this.last < 0 ? 0 : this.first, Math.max(this.last, 0));
  }
}
