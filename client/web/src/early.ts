// Before the page itself is read: opens the connection. The gateway sees by its address which session is wanted, and sends what its
// picture takes while the browser still reads the page and makes the canvas. The link takes it over (link.ts).

import { liveAddress, type Early } from './live';

const session = Number(new URLSearchParams(location.search).get('session') ?? 0);
const early: Early = { socket: new WebSocket(liveAddress(session)), session, heard: [] };
early.socket.binaryType = 'arraybuffer';
early.socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => early.heard.push(data);
(globalThis as unknown as Record<string, unknown>)['handgraftEarly'] = early;
