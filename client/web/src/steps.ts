// Which of a session's steps to undo were made as one: those of a drag. By their place among the steps, so that redo finds them, too; kept
// for as long as the browser's tab is, so that a page that is loaded again knows them.

const kMost = 500; // that the server keeps (core/session/history.h): at that many, the oldest go and all places shift

interface Group {
  from: number; // steps before its first
  to: number; // steps with its last
}

export class Steps {
  private groups: Group[] = [];
  private session = 0;

  /** Those of that session from now on; known ones are those of before, under the number that its server had lost. */
  of(session: number, areKnown = false): void {
    if (session === this.session) return;
    const isMoved = areKnown && this.session !== 0;
    this.session = session;
    if (isMoved) this.keep();
    else this.groups = this.kept();
  }

  /** There are so many steps, undone ones among them: others may have made fewer of them. */
  clip(count: number): void {
    this.groups = this.groups.filter((group) => group.to <= count);
  }

  /** An edit is about to be made behind so many steps: what could be redone is gone. */
  cut(count: number): void {
    if (count >= kMost) this.groups = [];
    else this.clip(count);
  }

  /** The last so many of those steps were made as one. */
  join(count: number, steps: number): void {
    const from = Math.max(0, count - steps);
    if (count >= kMost) this.groups = [];
    else this.clip(from);
    if (count > from + 1) this.groups.push({ from, to: count });
    this.keep();
  }

  /** How many to undo, of so many, or to do again behind so many, so that none is left in the middle of what is one. */
  back(count: number): number {
    const group = this.groups.find(({ from, to }) => from < count && count <= to);
    return group === undefined ? 1 : count - group.from;
  }

  forth(count: number): number {
    const group = this.groups.find(({ from, to }) => from <= count && count < to);
    return group === undefined ? 1 : group.to - count;
  }

  private get key(): string {
    return `handgraft-steps-${this.session}`;
  }

  private keep(): void {
    try {
      sessionStorage.setItem(this.key, JSON.stringify(this.groups));
    } catch {
      // In a frame, or in private: until it is loaded again.
    }
  }

  private kept(): Group[] {
    try {
      return JSON.parse(sessionStorage.getItem(this.key) ?? '[]') as Group[];
    } catch {
      return [];
    }
  }
}
