// SPDX-License-Identifier: BSD-2-Clause
// Messages from the program, or from the page itself where it was saved with its data.
import { Message } from './protocol';

export type ConnectionState = 'connecting' | 'connected' | 'lost' | 'stored';

const FIRST_PAUSE_MS = 500;
const LONGEST_PAUSE_MS = 5000;

function token(): string {
  const value = new URLSearchParams(location.search).get('token');
  return value ? `?token=${encodeURIComponent(value)}` : '';
}

/** The address of a download of the program. */
export function downloadUrl(name: string): string {
  return `download/${name}${token()}`;
}

export class Connection {
  private pauseMs = FIRST_PAUSE_MS;

  constructor(
    private readonly onMessage: (message: Message) => void,
    private readonly onState: (state: ConnectionState) => void,
    private readonly onError: (error: unknown) => void,
  ) {}

  start(): void {
    const stored = document.querySelectorAll('script[type="application/x-facet"]');
    if (stored.length === 0) return this.open();
    this.onState('stored');
    for (const element of stored) {
      const text = atob((element.textContent ?? '').trim());
      this.receive(Uint8Array.from(text, (c) => c.charCodeAt(0)).buffer);
    }
  }

  /** One message; what is wrong with it is reported, not thrown. */
  receive(buffer: ArrayBuffer): void {
    try {
      this.onMessage(new Message(buffer));
    } catch (error) {
      this.onError(error);
    }
  }

  private open(): void {
    this.onState('connecting');
    const url = new URL(`live${token()}`, location.href);
    url.protocol = 'ws:';
    const socket = new WebSocket(url);
    socket.binaryType = 'arraybuffer';
    socket.addEventListener('open', () => {
      this.pauseMs = FIRST_PAUSE_MS;
      this.onState('connected');
    });
    socket.addEventListener('message', (event: MessageEvent<ArrayBuffer>) => this.receive(event.data));
    socket.addEventListener('close', () => {
      this.onState('lost');
      setTimeout(() => this.open(), this.pauseMs);
      this.pauseMs = Math.min(2 * this.pauseMs, LONGEST_PAUSE_MS);
    });
  }
}
