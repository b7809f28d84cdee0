// Files that are dropped anywhere on the page.

import { h } from './dom';
import { dropped } from './files';
import type { OpenDialog } from './open';
import type { Session } from './session';

export function acceptDrops(session: Session, dialog: OpenDialog): void {
  const dropHere = h('div', { class: 'drop', hidden: true }, h('p', {}, 'Drop a hand (its folder or a zip), an object, contacts, or a session that was saved'));
  document.body.append(dropHere);
  const isOfFiles = (event: DragEvent) => event.dataTransfer?.types.includes('Files') === true;
  let inside = 0; // elements that the pointer has entered and not left
  window.addEventListener('dragenter', (event) => {
    if (!isOfFiles(event)) return;
    ++inside;
    dropHere.hidden = !session.mayOpen;
  });
  window.addEventListener('dragleave', (event) => {
    if (isOfFiles(event) && --inside <= 0) dropHere.hidden = true;
  });
  window.addEventListener('dragover', (event) => {
    if (!isOfFiles(event)) return;
    event.preventDefault(); // else the browser opens the file instead of the page
  });
  window.addEventListener('drop', (event) => {
    inside = 0;
    dropHere.hidden = true;
    if (!isOfFiles(event)) return;
    event.preventDefault();
    if (!session.link.isLive) session.notify('This page is a file, without a server: it loads nothing.', 'wrong');
    else if (!session.mayOpen) session.notify('This link is for looking: it loads nothing.', 'wrong');
    else void dialog.take(dropped(event.dataTransfer!));
  });
}
