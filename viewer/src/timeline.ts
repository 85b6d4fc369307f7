// SPDX-License-Identifier: BSD-2-Clause
// Play, pause, step, seek and speed; which moment of the run is shown.
import { byId, make, sharpContext } from './dom';
import type { Model } from './model';
import { css, STATUS_COLOURS } from './palette';

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16];
const MAX_WIDTH = 2000;

export class Timeline {
  stampNs = 0n;
  isPlaying = false;
  isAtEnd = true; // stays with the newest frame of a live run
  speed = 1;
  private readonly slider = make('input', { type: 'range', min: '0', max: '1', step: '0.001', id: 'seek',
    'aria-label': 'Moment of the run' });
  private readonly band = make('canvas');
  private readonly playButton = make('button', { id: 'play', title: 'Play or pause (space)' }, 'Play');
  private readonly time = make('span', { class: 'time', id: 'time' });
  private readonly speedSelect = make('select', { id: 'speed', title: 'Speed (+ and -)', 'aria-label': 'Speed' });
  private last = 0;
  private bandOf = '';

  constructor(private readonly model: Model, private readonly onChange: () => void) {
    for (const speed of SPEEDS) {
      this.speedSelect.append(make('option', { value: String(speed) }, `${speed}×`));
    }
    this.speedSelect.value = '1';
    const back = make('button', { id: 'back', title: 'One frame back (left arrow)' }, '◂');
    const on = make('button', { id: 'on', title: 'One frame on (right arrow)' }, '▸');
    back.addEventListener('click', () => this.step(-1));
    on.addEventListener('click', () => this.step(1));
    this.playButton.addEventListener('click', () => this.toggle());
    this.speedSelect.addEventListener('change', () => (this.speed = Number(this.speedSelect.value)));
    this.slider.addEventListener('input', () => this.seek(Number(this.slider.value)));
    byId('timeline').append(this.playButton, back, on,
      make('div', { class: 'track' }, this.band, this.slider), this.time, this.speedSelect);
    const tick = (now: number): void => {
      requestAnimationFrame(tick);
      if (this.isPlaying) this.advance(Math.min(now - this.last, 200));
      this.last = now;
    };
    requestAnimationFrame(tick);
  }

  /** Seconds since the first frame. */
  get seconds(): number {
    return Number(this.stampNs - this.model.range()[0]) / 1e9;
  }

  seek(seconds: number): void {
    const [first, last] = this.model.range();
    let stamp = first + BigInt(Math.round(1e9 * Math.min(seconds, 1e9)));
    if (stamp < first) stamp = first;
    this.isAtEnd = stamp >= last;
    this.stampNs = this.isAtEnd ? last : stamp;
    if (this.isAtEnd) this.setPlaying(false);
    this.show();
    this.onChange();
  }

  step(frames: number): void {
    this.setPlaying(false);
    const source = this.model.sources[0];
    if (!source || source.frames.count === 0) return;
    const index = Math.min(Math.max(source.frames.indexAt(this.stampNs) + frames, 0), source.frames.count - 1);
    this.stampNs = source.frames.stampNs(index);
    this.isAtEnd = index === source.frames.count - 1;
    this.show();
    this.onChange();
  }

  toggle(): void {
    if (!this.isPlaying && this.isAtEnd) this.seek(0);
    this.setPlaying(!this.isPlaying);
  }

  changeSpeed(by: number): void {
    const i = SPEEDS.indexOf(this.speed) + by;
    this.speed = SPEEDS[Math.min(Math.max(i, 0), SPEEDS.length - 1)]!;
    this.speedSelect.value = String(this.speed);
  }

  private setPlaying(playing: boolean): void {
    this.isPlaying = playing;
    this.playButton.textContent = playing ? 'Pause' : 'Play';
  }

  private advance(ms: number): void {
    this.seek(this.seconds + (this.speed * ms) / 1000);
  }

  /** After frames have come. */
  update(): void {
    const [first, last] = this.model.range();
    if (this.isAtEnd || this.stampNs < first) this.stampNs = last;
    this.show();
  }

  private show(): void {
    const [first, last] = this.model.range();
    const length = Number(last - first) / 1e9;
    this.slider.max = String(length);
    this.slider.value = String(this.seconds);
    const isLive = this.model.mode === 'live' && !this.model.ended;
    this.time.textContent = isLive && this.isAtEnd
      ? `live · ${this.seconds.toFixed(2)} s`
      : `${this.seconds.toFixed(2)} / ${length.toFixed(2)} s`;
    this.slider.setAttribute('aria-valuetext', this.time.textContent);
    this.drawBand(first, length);
  }

  /** The status over time: colour, and height for who does not tell colours apart. */
  private drawBand(first: bigint, length: number): void {
    const frames = this.model.sources[0]?.frames;
    const key = `${frames?.count} ${this.band.clientWidth} ${length}`;
    if (!frames || key === this.bandOf) return;
    this.bandOf = key;
    const context = sharpContext(this.band, 12);
    if (!context || frames.count === 0) return;
    const width = this.band.clientWidth, step = Math.max(1, Math.floor(frames.count / MAX_WIDTH));
    const px = Math.max(1, (width * step) / frames.count + 0.5);
    for (let i = 0; i < frames.count; i += step) {
      const f = frames.at(i)!;
      const x = (width * Number(f.stampNs - first)) / 1e9 / Math.max(length, 1e-9);
      const height = [4, 8, 10, 12][f.status]!;
      context.fillStyle = css(STATUS_COLOURS[f.status]!);
      context.fillRect(x, 12 - height, px, height);
    }
  }
}
