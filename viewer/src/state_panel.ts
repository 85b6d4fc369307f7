// SPDX-License-Identifier: BSD-2-Clause
// The numbers of the frame that is shown, and where its time went.
import { byId, make, sharpContext, colourOf } from './dom';
import type { Frame, Model, Source } from './model';
import { css, STAGE_COLOURS, STATUS_NAMES } from './palette';

const DEG = 180 / Math.PI;

function norm(v: ArrayLike<number>, at: number): number {
  return Math.hypot(v[at]!, v[at + 1]!, v[at + 2]!);
}

function number(value: number, digits: number, unit: string): string {
  return Number.isFinite(value) ? `${value.toFixed(digits)} ${unit}` : '–';
}

function triple(v: ArrayLike<number>, at: number, scale: number, digits: number, unit: string): string {
  const parts = [0, 1, 2].map((k) => scale * v[at + k]!);
  return parts.every(Number.isFinite) ? `${parts.map((p) => p.toFixed(digits)).join('  ')} ${unit}` : '–';
}

export class StatePanel {
  private readonly status = make('span', { class: 'pill', id: 'status' });
  private readonly list = make('dl', { class: 'values', id: 'values' });
  private readonly chart = make('canvas', { class: 'chart', id: 'speed-chart', 'aria-label': 'Speed over time' });

  constructor() {
    byId('state').append(make('div', { class: 'status' }, this.status), this.list,
      make('h2', {}, 'Speed and 3-sigma of the position'), this.chart);
  }

  show(source: Source, index: number): void {
    const f = source.frames.at(index);
    if (!f) return;
    const name = STATUS_NAMES[f.status] ?? 'ok';
    this.status.textContent = name;
    this.status.className = `pill ${['', 'good', 'warn', 'bad'][f.status]}`;
    const rows: [string, string][] = [
      ['Stamp', `${(Number(f.stampNs / 1000n) / 1e6).toFixed(3)} s`],
      ['Frame', `${index + 1} of ${source.frames.count}${f.isKeyframe ? ', keyframe' : ''}`],
    ];
    if (f.hasPose) rows.push(...poseRows(f));
    if (source.truth) rows.push(...errorRows(source, index));
    rows.push(['Landmarks', String(f.counts[2] ?? 0)], ['Planes', String(f.counts[3] ?? 0)],
      ['On planes', String(f.counts[4] ?? 0)], ['Latency', number(f.counts[1] || NaN, 1, 'ms')]);
    if (f.segment > 0) rows.push(['Segment', String(f.segment)]);
    this.list.replaceChildren(...rows.flatMap(([term, value]) => [make('dt', {}, term), make('dd', {}, value)]));
    if (f.reason) this.list.append(make('dd', { class: 'wide', id: 'reason' }, f.reason));
    this.drawChart(source, index);
  }

  private drawChart(source: Source, index: number): void {
    const height = 64, context = sharpContext(this.chart, height);
    if (!context) return;
    const { frames } = source, n = frames.count, width = this.chart.clientWidth;
    const step = Math.max(1, Math.floor(n / width));
    const speeds: [number, number][] = [], sigmas: [number, number][] = [];
    let maxSpeed = 0.1, maxSigma = 0.01;
    for (let i = 0; i < n; i += step) {
      const f = frames.at(i)!;
      if (!f.hasPose) continue;
      const v = norm(f.motion, 0), s = 3 * norm(f.sigmas, 0);
      if (Number.isFinite(v)) speeds.push([i, v]);
      if (Number.isFinite(s)) sigmas.push([i, s]);
      maxSpeed = Math.max(maxSpeed, v || 0);
      maxSigma = Math.max(maxSigma, s || 0);
    }
    const draw = (line: [number, number][], max: number, colour: string, dash: number[]): void => {
      context.beginPath();
      context.setLineDash(dash);
      context.strokeStyle = colour;
      context.lineWidth = 1.3;
      line.forEach(([i, y]) => context.lineTo((width * i) / Math.max(n - 1, 1), height - 3 - (y / max) * (height - 18)));
      context.stroke();
    };
    draw(speeds, maxSpeed, colourOf('--accent'), []);
    draw(sigmas, maxSigma, colourOf('--warn'), [4, 3]);
    context.setLineDash([]);
    context.fillStyle = colourOf('--text');
    context.fillRect((width * index) / Math.max(n - 1, 1), 0, 1, height);
    context.font = '10px system-ui, sans-serif';
    context.fillStyle = colourOf('--accent');
    context.fillText(`— speed ≤ ${maxSpeed.toFixed(2)} m/s`, 4, 10);
    context.fillStyle = colourOf('--warn');
    const text = `- - 3σ ≤ ${(100 * maxSigma).toFixed(1)} cm`;
    context.fillText(text, width - context.measureText(text).width - 4, 10);
  }
}

function poseRows(f: Frame): [string, string][] {
  return [
    ['Position', triple(f.pose, 0, 1, 2, 'm')],
    ['Position 1σ', triple(f.sigmas, 0, 100, 1, 'cm')],
    ['Rotation 1σ', triple(f.sigmas, 3, DEG, 2, '°')],
    ['Speed', number(norm(f.motion, 0), 2, 'm/s')],
    ['Velocity 1σ', triple(f.sigmas, 6, 100, 1, 'cm/s')],
    ['Gyro bias', triple(f.motion, 3, 1e3, 1, 'mrad/s')],
    ['Accel. bias', triple(f.motion, 6, 1, 3, 'm/s²')],
  ];
}

/** The distance to the truth, and the largest of it up to this moment. */
function errorRows(source: Source, index: number): [string, string][] {
  let largest = NaN;
  for (let i = 0; i <= index; i++) {
    const error = source.errors[i]!;
    if (error > largest || Number.isNaN(largest)) largest = error;
  }
  return [
    ['Error', number(1000 * source.errors[index]!, 1, 'mm')],
    ['Largest so far', number(1000 * largest, 1, 'mm')],
  ];
}

const STRIP_FRAMES = 90;

export class TimingPanel {
  private readonly strip = make('canvas', { id: 'strip', 'aria-label': 'Time of each stage, frame by frame' });
  private readonly table = make('table');

  constructor() {
    byId('timing').append(this.strip, this.table);
  }

  show(model: Model, source: Source, index: number): void {
    const { frames } = source;
    if (frames.count === 0) return;
    const first = Math.max(0, Math.min(index - STRIP_FRAMES / 2, frames.count - STRIP_FRAMES) | 0);
    const last = Math.min(first + STRIP_FRAMES, frames.count);
    const sums: number[] = model.stages.map(() => 0);
    let max = 1;
    for (let i = first; i < last; i++) {
      const { stages } = frames.at(i)!;
      let total = 0;
      stages.forEach((ms, k) => {
        if (!Number.isFinite(ms)) return;
        sums[k]! += ms;
        total += ms;
      });
      max = Math.max(max, total);
    }
    this.draw(source, first, last, index, max);
    const current = frames.at(index)?.stages;
    const rows = model.stages.flatMap((name, k) => {
      const mean = sums[k]! / (last - first);
      if (mean === 0) return [];
      const swatch = make('i', { style: `background:${css(STAGE_COLOURS[k % STAGE_COLOURS.length]!)}` });
      return [make('tr', {}, make('td', {}, swatch), make('td', {}, name),
        make('td', {}, (current?.[k] ?? NaN).toFixed(2)), make('td', {}, mean.toFixed(2)))];
    });
    const head = make('tr', {}, make('th'), make('th'), make('th', {}, 'now ms'), make('th', {}, 'mean ms'));
    this.table.replaceChildren(head, ...rows);
  }

  private draw(source: Source, first: number, last: number, index: number, max: number): void {
    const height = 90, context = sharpContext(this.strip, height);
    if (!context) return;
    const width = this.strip.clientWidth, bar = width / STRIP_FRAMES;
    for (let i = first; i < last; i++) {
      let y = height;
      source.frames.at(i)!.stages.forEach((ms, k) => {
        if (!(ms > 0)) return;
        const h = (ms / max) * (height - 14);
        context.fillStyle = css(STAGE_COLOURS[k % STAGE_COLOURS.length]!);
        context.globalAlpha = i === index ? 1 : 0.75;
        context.fillRect((i - first) * bar, y - h, Math.max(bar - 0.5, 0.5), h);
        y -= h;
      });
      if (i === index) {
        context.globalAlpha = 1;
        context.fillStyle = colourOf('--text');
        context.fillRect((i - first + 0.5) * bar, 0, 1, y);
      }
    }
    context.globalAlpha = 1;
    context.fillStyle = colourOf('--soft');
    context.font = '10px system-ui, sans-serif';
    context.fillText(`${max.toFixed(1)} ms processor time`, 4, 10);
  }
}
