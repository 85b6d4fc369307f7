// SPDX-License-Identifier: BSD-2-Clause
// Short words for what the page is made of.

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element ${id}`);
  return element as T;
}

type Attributes = Record<string, string>;

export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Attributes = {}, ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** Buttons of which one is chosen. */
export class Segments<T extends string> {
  private readonly buttons = new Map<T, HTMLButtonElement>();

  constructor(parent: HTMLElement, choices: [T, string, string][], private readonly onChoose: (choice: T) => void) {
    for (const [value, text, title] of choices) {
      const button = make('button', { role: 'radio', title, 'data-value': value }, text);
      button.addEventListener('click', () => this.choose(value));
      this.buttons.set(value, button);
      parent.append(button);
    }
  }

  choose(value: T): void {
    this.show(value);
    this.onChoose(value);
  }

  show(value: T): void {
    for (const [v, b] of this.buttons) b.setAttribute('aria-checked', String(v === value));
  }
}

/** A canvas's context, sized to its pixels on the screen. */
export function sharpContext(canvas: HTMLCanvasElement, height: number): CanvasRenderingContext2D | null {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth;
  if (width === 0) return null;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  canvas.style.height = `${height}px`;
  const context = canvas.getContext('2d');
  context?.scale(ratio, ratio);
  return context;
}

export function save(blob: Blob, name: string): void {
  const link = make('a', { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export function colourOf(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
