// SPDX-License-Identifier: BSD-2-Clause
// The page: messages go into the model, changes of it into the picture and the panels.
import './style.css';
import { Connection, downloadUrl, type ConnectionState } from './connection';
import { byId, colourOf, make, save, Segments } from './dom';
import { ImagePanel } from './image_panel';
import { Measure, type Measurement, type MeasureMode } from './measure';
import { type Change, imageOf, meshOf, Model, type Plane } from './model';
import { ColourPanel, LayerPanel, makeHelp, PlanePanel } from './panels';
import { describePlane } from './plane_object';
import { Message } from './protocol';
import { type Arrangement, type CameraMode, Stage } from './stage';
import { StatePanel, TimingPanel } from './state_panel';
import { Timeline } from './timeline';

const CLICK_PX = 5;

class Page {
  readonly model = new Model();
  readonly errors: string[] = [];
  readonly stage: Stage;
  readonly timeline: Timeline;
  readonly measure = new Measure(this.model);
  readonly image = new ImagePanel();
  measurement: Measurement | null = null;
  connectionState: ConnectionState = 'connecting';
  firstMeshMs = 0;
  private readonly colours: ColourPanel;
  private readonly layers: LayerPanel;
  private readonly planes = new PlanePanel((plane) => this.selectPlane(plane));
  private readonly state = new StatePanel();
  private readonly timing = new TimingPanel();
  private readonly help = makeHelp();
  private readonly connection: Connection;
  private readonly camera: Segments<CameraMode>;
  private readonly measureButtons: Segments<MeasureMode>;
  private arrangement: Segments<Arrangement> | null = null;
  private readonly changed = new Set<string>();
  private horizonShown = '';
  private isFetching = false;
  private recordedShown = '';
  private isFetchingImage = false;
  private selected: Plane | null = null;

  constructor() {
    this.stage = new Stage(byId<HTMLCanvasElement>('canvas'), byId('overlay'), this.model, (p) => this.selectPlane(p));
    this.layers = new LayerPanel(this.stage, this.model);
    this.colours = new ColourPanel(this.stage, this.model, () => this.layers.update());
    this.timeline = new Timeline(this.model, () => this.showMoment());
    this.camera = new Segments(byId('camera'), [
      ['orbit', 'Orbit', 'Around the scene (O)'], ['follow', 'Follow', 'Behind the camera (Q)'],
      ['top', 'Top', 'From above (V)'],
    ], (mode) => {
      this.stage.setCameraMode(mode);
      this.showMoment();
    });
    this.measureButtons = new Segments(byId('measure'), [
      ['off', 'Look', 'No measuring (Esc)'], ['points', 'Distance', 'Between two points (D)'],
      ['plane', 'To plane', 'From a plane to a point (N)'],
    ], (mode) => this.setMeasurement(this.measure.setMode(mode)));
    this.camera.show('orbit');
    this.measureButtons.show('off');
    this.addControls();
    this.setTheme(matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark');
    new ResizeObserver(() => this.resize()).observe(byId('view'));
    this.connection = new Connection(
      (m) => this.apply(m), (s) => this.showConnection(s), (e) => this.report(e));
    this.connection.start();
  }

  receive(buffer: ArrayBuffer): void {
    this.connection.receive(buffer);
  }

  // ------------------------------------------------------------------ messages

  private apply(message: Message): void {
    const { change, source, mesh } = this.model.apply(message);
    if (change === 'reset') this.reset();
    if (change === 'hello') this.showHello();
    if (mesh) {
      this.stage.setMesh(source, mesh);
      if (this.firstMeshMs === 0) this.firstMeshMs = performance.now();
    }
    // The rest is shown once, after all messages of this moment.
    if (this.changed.size === 0) setTimeout(() => this.showChanges(), 0);
    this.changed.add(`${change} ${source}`);
  }

  private reset(): void {
    this.stage.reset();
    this.horizonShown = this.recordedShown = '';
    this.showHello();
    const isPair = this.model.sources.length > 1;
    byId('arrangement').hidden = !isPair;
    byId('arrangement').replaceChildren();
    if (isPair) {
      this.arrangement = new Segments(byId('arrangement'), [
        ['a', 'A', 'The first result (1)'], ['b', 'B', 'The second result (2)'], ['overlay', 'Both', 'Both (3)'],
        ['side', 'A | B', 'Beside each other (4)'],
      ], (a) => this.arrange(a));
      this.arrangement.choose('side');
    }
    // At the end of a run the horizon lies in the map.
    this.layers.set('horizon', this.model.mode === 'live');
    if (this.model.mode === 'live') this.camera.choose('follow');
  }

  private showHello(): void {
    const names = this.model.sources.map((s, i) => (this.model.sources.length > 1 ? `${'AB'[i]} ${s.hello.name}` : s.hello.name));
    byId('names').textContent = names.join(' · ');
    document.title = `${names.join(' · ')} · Facet`;
    const list = byId('downloads').querySelector('.menu-list')!;
    list.replaceChildren();
    for (const s of this.model.sources) {
      list.append(make('span', {}, s.hello.name));
      for (const name of s.hello.downloads) {
        list.append(make('a', { href: downloadUrl(name), download: '' }, name.split('/').pop()!));
      }
    }
    byId('downloads').hidden = this.connectionState === 'stored' || this.model.sources.every((s) => s.hello.downloads.length === 0);
  }

  private showChanges(): void {
    const changes = [...this.changed].map((c) => c.split(' ') as [Change, string]);
    this.changed.clear();
    for (const [i, source] of this.model.sources.entries()) {
      if (changes.some(([c, at]) => (c === 'frames' || c === 'truth') && Number(at) === i)) source.updateErrors();
    }
    for (const [change, at] of changes) {
      const i = Number(at);
      if (change === 'frames') this.stage.setFrames(i);
      if (change === 'truth') this.model.sources.forEach((_, k) => this.stage.setFrames(k));
      if (change === 'keyframes' || change === 'truth') this.stage.setKeyframes(i);
      if (change === 'planes') this.stage.setPlanes(i);
      if (change === 'points') this.stage.setPoints(i);
      if (change === 'image') this.showImage(i);
      if (change === 'ended') this.showConnection(this.connectionState);
    }
    const kinds = new Set(changes.map(([c]) => c));
    if (kinds.has('mesh')) this.stage.updateRange();
    if (kinds.has('planes')) this.showPlanes();
    if (kinds.has('truth')) this.stage.applyLayers();
    if (kinds.has('mesh') || kinds.has('truth') || kinds.has('points') || kinds.has('reset')) {
      this.colours.update();
      this.layers.update();
    }
    if (kinds.has('mesh') || kinds.has('frames')) {
      byId('empty').hidden = true;
      this.stage.frameFirst();
    }
    if (kinds.has('frames')) this.timeline.update();
    this.showMoment();
  }

  private report(error: unknown): void {
    const text = error instanceof Error ? error.message : String(error);
    this.errors.push(text);
    const close = make('button', { 'aria-label': 'Close' }, '✕');
    const banner = byId('message');
    close.addEventListener('click', () => (banner.hidden = true));
    banner.replaceChildren(make('span', {}, `Data could not be shown: ${text}`), close);
    banner.hidden = false;
  }

  private showConnection(state: ConnectionState): void {
    this.connectionState = state;
    const pill = byId('connection');
    const { mode, ended } = this.model;
    let text = { connecting: 'connecting', connected: mode === 'live' ? 'live' : 'result', stored: 'report',
      lost: 'connection lost, trying again' }[state];
    if (ended && state !== 'stored') text = ended.code === 0 ? 'run ended' : `run ended: ${ended.message}`;
    pill.textContent = text;
    pill.title = text;
    const isBad = ended ? ended.code !== 0 : state === 'lost';
    pill.className = `pill ${isBad ? 'bad' : state === 'connected' && mode === 'live' && !ended ? 'good' : ''}`;
  }

  // ------------------------------------------------------------------ the moment

  private mainSource(): number {
    return this.stage.arrangement === 'b' && this.model.sources.length > 1 ? 1 : 0;
  }

  indices(): number[] {
    return this.model.sources.map((s) => s.frames.indexAt(this.timeline.stampNs));
  }

  private showMoment(): void {
    if (this.model.sources.length === 0) return;
    const indices = this.indices();
    this.stage.setMoment(indices, this.timeline.isPlaying);
    const i = this.mainSource(), source = this.model.sources[i]!;
    this.state.show(source, indices[i]!);
    this.timing.show(this.model, source, indices[i]!);
    this.showHorizon().catch((e: unknown) => this.report(e));
    this.showRecorded().catch((e: unknown) => this.report(e));
    if (this.connectionState === 'connected') this.showConnection('connected');
  }

  /** The horizon mesh of the moment, where the run has written them (--mesh-every). */
  private async showHorizon(): Promise<void> {
    if (this.isFetching || this.model.mode === 'live' || this.connectionState === 'stored') return;
    const wanted = this.model.sources.map((s) => {
      const list = s.hello.horizon ?? [];
      let best: string | undefined;
      for (const h of list) if (BigInt(h.stamp_ns) <= this.timeline.stampNs) best = h.name;
      return best;
    });
    const key = wanted.join(' ');
    if (key === this.horizonShown || wanted.every((w) => !w)) return;
    this.isFetching = true;
    try {
      for (const [i, name] of wanted.entries()) {
        if (!name || this.horizonShown.split(' ')[i] === name) continue;
        const answer = await fetch(downloadUrl(name));
        if (!answer.ok) throw new Error(`${name}: ${answer.status} ${answer.statusText}`);
        this.model.sources[i]!.meshes.set('horizon', meshOf(new Message(await answer.arrayBuffer())));
        this.stage.setMesh(i, 'horizon');
      }
      this.horizonShown = key;
    } finally {
      this.isFetching = false;
    }
    await this.showHorizon();
  }

  private showImage(source: number): void {
    const { image } = this.model.sources[source]!;
    if (!image) return;
    byId('tabs').querySelector<HTMLElement>('[data-tab=image]')!.hidden = false;
    this.image.set(image).catch((e: unknown) => this.report(e));
  }

  /** The recorded image of the moment, where the program knows the recording of a finished run. */
  private async showRecorded(): Promise<void> {
    const i = this.mainSource(), source = this.model.sources[i]!;
    if (this.isFetchingImage || this.connectionState !== 'connected' || !source.hello.images) return;
    const frame = source.frames.at(this.indices()[i]!);
    if (!frame?.hasPose || `${i} ${frame.stampNs}` === this.recordedShown) return;
    this.isFetchingImage = true;
    try {
      const answer = await fetch(downloadUrl(`${'ab'[i]}/image-${frame.stampNs}.facet`));
      this.recordedShown = `${i} ${frame.stampNs}`;
      if (answer.status === 404) return; // the recording lacks this one
      if (!answer.ok) throw new Error(`the image: ${await answer.text()}`);
      source.image = imageOf(new Message(await answer.arrayBuffer()));
      this.showImage(i);
    } finally {
      this.isFetchingImage = false;
    }
    await this.showRecorded();
  }

  // ------------------------------------------------------------------ controls

  private addControls(): void {
    byId('frame').addEventListener('click', () => this.stage.frameAll());
    byId('screenshot').addEventListener('click', () => this.saveScreenshot());
    byId('theme').addEventListener('click', () => this.switchTheme());
    byId('help-open').addEventListener('click', () => this.help.showModal());
    document.addEventListener('click', (event) => {
      const menu = byId<HTMLDetailsElement>('downloads');
      if (!menu.contains(event.target as Node)) menu.open = false;
    });
    const tabs = byId('tabs');
    for (const [id, text] of [['none', '3D'], ['layers', 'Layers'], ['colouring', 'Colour'], ['planes', 'Planes'],
      ['state', 'State'], ['image', 'Image'], ['timing', 'Time']] as const) {
      const button = make('button', { role: 'tab', 'data-tab': id }, text);
      button.addEventListener('click', () => this.setTab(id));
      if (id === 'image') button.hidden = true; // until there is one
      tabs.append(button);
    }
    this.setTab('none');
    this.addPointer();
    document.addEventListener('keydown', (event) => this.onKey(event));
  }

  private setTab(id: string): void {
    document.body.dataset['tab'] = id;
    for (const b of byId('tabs').children) b.setAttribute('aria-selected', String((b as HTMLElement).dataset['tab'] === id));
    this.resize();
    this.showMoment();
    this.image.draw();
  }

  private addPointer(): void {
    const canvas = byId('canvas');
    let down: PointerEvent | null = null;
    canvas.addEventListener('pointerdown', (e) => (down = e.isPrimary && e.button === 0 ? e : null));
    canvas.addEventListener('pointerup', (e) => {
      if (!down || Math.hypot(e.clientX - down.clientX, e.clientY - down.clientY) > CLICK_PX) return;
      this.onPick(e.clientX, e.clientY);
    });
  }

  private onPick(x: number, y: number): void {
    const hit = this.stage.pick(x, y);
    if (this.measure.mode !== 'off') {
      if (hit) this.setMeasurement(this.measure.add(hit));
      return;
    }
    const plane = hit ? this.model.sources[hit.source]?.planes.find((p) => p.id === hit.planeId) : undefined;
    this.showSelected(plane ?? null);
  }

  private selectPlane(plane: Plane): void {
    if (this.measure.mode === 'plane') return this.setMeasurement(this.measure.setPlane(plane));
    this.showSelected(this.selected?.id === plane.id ? null : plane);
  }

  private showSelected(plane: Plane | null): void {
    this.selected = plane;
    this.planes.selected = plane?.id ?? null;
    this.stage.selectPlane(plane?.id ?? null);
    this.showPlanes();
    this.showCard(plane ? describePlane(plane) : '');
  }

  private showPlanes(): void {
    this.planes.show(this.model.sources[this.mainSource()]?.planes ?? []);
  }

  private setMeasurement(measurement: Measurement): void {
    this.measurement = measurement;
    this.stage.showMeasure(measurement.points);
    this.showCard(measurement.text);
  }

  private showCard(text: string): void {
    byId('card').hidden = text === '';
    byId('card').textContent = text;
  }

  private arrange(arrangement: Arrangement): void {
    this.stage.arrangement = arrangement;
    this.showPlanes();
    this.showMoment();
    this.stage.frameAll();
  }

  private async saveScreenshot(): Promise<void> {
    try {
      save(await this.stage.screenshot(), 'facet.png');
    } catch (error) {
      this.report(error);
    }
  }

  private switchTheme(): void {
    this.setTheme(document.documentElement.dataset['theme'] === 'light' ? 'dark' : 'light');
  }

  private setTheme(theme: 'dark' | 'light'): void {
    document.documentElement.dataset['theme'] = theme;
    this.stage.setTheme(colourOf('--scene'), colourOf('--grid'));
    this.showMoment();
  }

  private resize(): void {
    this.stage.resize();
    this.timeline.update();
  }

  private onKey(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (event.altKey || event.metaKey || this.help.open || target.tagName === 'SELECT') return;
    if (this.handleKey(event.key, event.ctrlKey, event.shiftKey, target)) event.preventDefault();
  }

  private handleKey(key: string, ctrl: boolean, shift: boolean, target: HTMLElement): boolean {
    const { timeline, stage } = this;
    const turn = 0.1;
    if (shift && key.startsWith('Arrow')) {
      if (key === 'ArrowLeft') stage.nudge(-turn, 0, 1);
      if (key === 'ArrowRight') stage.nudge(turn, 0, 1);
      if (key === 'ArrowUp') stage.nudge(0, -turn, 1);
      if (key === 'ArrowDown') stage.nudge(0, turn, 1);
      return true;
    }
    switch (key) {
      case ' ':
        if (target.tagName === 'BUTTON' || target.tagName === 'INPUT' || target.tagName === 'SUMMARY') return false;
        timeline.toggle();
        return true;
      case 'ArrowLeft': ctrl ? timeline.seek(timeline.seconds - 1) : timeline.step(-1); return true;
      case 'ArrowRight': ctrl ? timeline.seek(timeline.seconds + 1) : timeline.step(1); return true;
      case 'Home': timeline.seek(0); return true;
      case 'End': timeline.seek(Infinity); return true;
      case 'PageUp': stage.nudge(0, 0, 1 / 1.2); return true;
      case 'PageDown': stage.nudge(0, 0, 1.2); return true;
      case '+': timeline.changeSpeed(1); return true;
      case '-': timeline.changeSpeed(-1); return true;
      case '?': this.help.showModal(); return true;
      case 'Escape':
        this.measureButtons.choose('off');
        return true;
    }
    if (ctrl) return false;
    const arrangements: Record<string, Arrangement> = { 1: 'a', 2: 'b', 3: 'overlay', 4: 'side' };
    const k = key.toLowerCase();
    if (this.model.sources.length > 1 && (arrangements[k] || k === 'x')) {
      this.arrangement?.choose(arrangements[k] ?? (stage.arrangement === 'a' ? 'b' : 'a'));
      return true;
    }
    switch (k) {
      case 'f': stage.frameAll(); return true;
      case 'q': this.camera.choose('follow'); return true;
      case 'o': this.camera.choose('orbit'); return true;
      case 'v': this.camera.choose('top'); return true;
      case 'c': this.colours.next(); return true;
      case 'd': this.measureButtons.choose('points'); return true;
      case 'n': this.measureButtons.choose('plane'); return true;
      case 'p': void this.saveScreenshot(); return true;
      case 't': this.switchTheme(); return true;
      default: return this.layers.toggleByKey(k);
    }
  }

  /** What tests look at. */
  stats(): Record<string, unknown> {
    return {
      ...this.stage.stats(),
      mode: this.model.mode,
      connection: this.connectionState,
      errors: [...this.errors],
      messages: this.model.numMessages,
      ended: this.model.ended,
      names: this.model.sources.map((s) => s.hello.name),
      frameCounts: this.model.sources.map((s) => s.frames.count),
      planeIds: this.model.sources.map((s) => s.planes.map((p) => p.id)),
      keyframeCounts: this.model.sources.map((s) => s.keyframes?.stamps.length ?? 0),
      truthCounts: this.model.sources.map((s) => s.truth?.stamps.length ?? 0),
      largestErrors: this.model.sources.map((s) => s.largestError),
      errorNow: this.model.sources.map((s, i) => s.errors[this.indices()[i]!] ?? null),
      stampNs: String(this.timeline.stampNs),
      indices: this.indices(),
      isPlaying: this.timeline.isPlaying,
      speed: this.timeline.speed,
      layers: { ...this.stage.layers },
      colouring: this.stage.colouring,
      arrangement: this.stage.arrangement,
      cameraMode: this.stage.cameraMode,
      measureMode: this.measure.mode,
      distance: this.measurement?.distance ?? null,
      selected: this.selected?.id ?? null,
      horizonStamps: this.model.sources.map((s) => String(s.meshes.get('horizon')?.stampNs ?? '')),
      image: { stampNs: String(this.image.stampNs), tracks: this.image.numTracks, triangles: this.image.numTriangles },
      firstMeshMs: this.firstMeshMs,
    };
  }

  pose(): number[] {
    const i = this.mainSource();
    return [...(this.model.sources[i]?.frames.at(this.indices()[i]!)?.pose ?? [])];
  }
}

declare global {
  interface Window {
    facet: { stats(): Record<string, unknown>; pose(): number[]; receive(buffer: ArrayBuffer): void };
  }
}

try {
  const page = new Page();
  window.facet = {
    stats: () => page.stats(), pose: () => page.pose(), receive: (buffer) => page.receive(buffer),
  };
} catch (error) {
  const text = error instanceof Error ? error.message : String(error);
  byId('empty').textContent = `The 3D view cannot be shown: ${text}. It needs WebGL 2.`;
}
