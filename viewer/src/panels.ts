// SPDX-License-Identifier: BSD-2-Clause
// The lists at the left: colours with their legend, layers, planes; and the help.
import { byId, make } from './dom';
import type { Colouring } from './mesh_object';
import type { Model, Plane } from './model';
import { AMOUNT_GRADIENT, css, NO_PLANE, planeColour, SOURCE_COLOURS } from './palette';
import { describePlane } from './plane_object';
import type { Layer, Stage } from './stage';

const COLOURINGS: [Colouring, string][] = [
  ['plane', 'Plane'], ['normal', 'Normal'], ['height', 'Height'], ['image', 'Image'], ['age', 'Age'],
  ['sigma', 'Uncertainty (1 sigma)'], ['error', 'Distance to the truth'], ['source', 'Result'],
];

export class ColourPanel {
  private readonly select = make('select', { id: 'colour', 'aria-label': 'Colour of the mesh' });
  private readonly legend = make('div', { class: 'legend', id: 'legend' });

  constructor(
    private readonly stage: Stage, private readonly model: Model, private readonly onLayers: () => void,
  ) {
    byId('colouring').append(this.select, this.legend);
    this.select.addEventListener('change', () => this.choose(this.select.value as Colouring));
    this.update();
  }

  choose(colouring: Colouring): void {
    this.stage.choose(colouring);
    this.update();
    this.onLayers();
  }

  next(): void {
    const offered = COLOURINGS.map(([c]) => c).filter((c) => this.stage.has(c));
    this.choose(offered[(offered.indexOf(this.stage.colouring) + 1) % offered.length]!);
  }

  update(): void {
    const offered = COLOURINGS.filter(([c]) => this.stage.has(c));
    if (this.select.options.length !== offered.length) {
      this.select.replaceChildren(...offered.map(([value, text]) => make('option', { value }, text)));
    }
    this.select.value = this.stage.colouring;
    this.legend.replaceChildren(...this.legendOf(this.stage.colouring));
  }

  private legendOf(colouring: Colouring): (Node | string)[] {
    const { low, high } = this.stage.range;
    const bar = (unit: string, scale: number, digits: number): Node[] => [
      make('div', { class: 'bar', style: `background:${AMOUNT_GRADIENT}` }),
      make('div', { class: 'ends' }, make('span', {}, `${(scale * low).toFixed(digits)} ${unit}`),
        make('span', {}, `${(scale * high).toFixed(digits)} ${unit}`)),
    ];
    switch (colouring) {
      case 'plane': return ['Each plane has a colour and a label; grey lies on none.'];
      case 'normal': return ['Red, green and blue are the x, y and z of the normal: floors blue, ceilings yellow.'];
      case 'image': return ['As the camera saw it.'];
      case 'source': return this.model.sources.map((s, i) => make('div', {},
        make('i', { style: `display:inline-block;width:12px;height:12px;background:${css(SOURCE_COLOURS[i]!)}` }),
        ` ${'AB'[i]}: ${s.hello.name}`));
      case 'height': return bar('m', 1, 2);
      case 'age': return bar('s', 1, 1);
      case 'sigma': return [...bar('cm', 100, 1), make('div', {},
        '1-sigma of the distance from the camera; grey: not known. Only the horizon mesh has it.')];
      case 'error': return bar('cm', 100, 1);
    }
  }
}

const LAYERS: [Layer, string, string][] = [
  ['map', 'Map', 'M'], ['horizon', 'Horizon mesh', 'H'], ['planes', 'Planes', 'L'], ['landmarks', 'Landmarks', ''],
  ['trajectory', 'Trajectory', 'J'], ['keyframes', 'Keyframes', 'K'], ['ellipsoids', '3-sigma ellipsoids', 'E'],
  ['frustum', 'Camera', ''], ['truth', 'True trajectory', ''],
  ['error', 'Error along the path', ''], ['grid', 'Grid, 1 m', 'G'],
  ['backs', 'Back sides', 'B'], ['edges', 'Wireframe', 'W'],
];

export class LayerPanel {
  private readonly boxes = new Map<Layer, HTMLInputElement>();
  private readonly rows = new Map<Layer, HTMLElement>();
  private readonly errorLegend = make('div', { class: 'legend', id: 'error-legend' });

  constructor(private readonly stage: Stage, private readonly model: Model) {
    for (const [layer, text, key] of LAYERS) {
      const box = make('input', { type: 'checkbox', id: `layer-${layer}` });
      box.addEventListener('change', () => this.set(layer, box.checked));
      const row = make('label', {}, box, text, make('span', { class: 'key' }, key));
      this.boxes.set(layer, box);
      this.rows.set(layer, row);
      byId('layers').append(row);
      if (layer === 'error') byId('layers').append(this.errorLegend);
    }
    this.update();
  }

  toggleByKey(key: string): boolean {
    const found = LAYERS.find(([, , k]) => k !== '' && k.toLowerCase() === key);
    if (!found) return false;
    this.set(found[0], !this.stage.layers[found[0]]);
    return true;
  }

  set(layer: Layer, on: boolean): void {
    this.stage.layers[layer] = on;
    this.stage.applyLayers();
    this.update();
  }

  update(): void {
    for (const [layer, box] of this.boxes) box.checked = this.stage.layers[layer];
    const hasTruth = this.model.sources.some((s) => s.truth);
    this.rows.get('truth')!.hidden = this.rows.get('error')!.hidden = !hasTruth;
    this.errorLegend.hidden = !hasTruth || !this.stage.layers.error;
    this.errorLegend.replaceChildren(
      make('div', { class: 'bar', style: `background:${AMOUNT_GRADIENT}` }),
      make('div', { class: 'ends' }, make('span', {}, '0 mm'), make('span', {}, 'to the truth'),
        make('span', {}, `${(1000 * this.model.largestError).toFixed(1)} mm`)));
    this.rows.get('landmarks')!.hidden = !this.model.sources.some((s) => s.points.length > 0);
  }
}

export class PlanePanel {
  selected: number | null = null;
  private readonly list = make('div', { class: 'plane-list', id: 'plane-list' });

  constructor(private readonly onSelect: (plane: Plane) => void) {
    byId('planes').append(this.list);
  }

  show(planes: Plane[]): void {
    const sorted = [...planes].sort((a, b) => b.area_m2 - a.area_m2);
    this.list.replaceChildren(...sorted.map((plane) => {
      const sigma = plane.sigma_d_m > 0 ? ` ±${(100 * plane.sigma_d_m).toFixed(1)} cm` : '';
      const button = make('button', { class: 'plane', title: describePlane(plane), 'data-plane': String(plane.id) },
        make('i', { style: `background:${css(planeColour(plane.id))}` }), `${plane.label} ${plane.id}`,
        make('small', {}, `${plane.area_m2.toFixed(1)} m²${sigma}`));
      button.classList.toggle('selected', plane.id === this.selected);
      button.addEventListener('click', () => this.onSelect(plane));
      return button;
    }));
    if (sorted.length === 0) this.list.append(make('small', { style: `color:${css(NO_PLANE)}` }, 'None'));
  }
}

const KEYS: [string, string][] = [
  ['drag, one finger', 'turn'], ['right drag, two fingers', 'move'], ['wheel, pinch', 'closer or farther'],
  ['click, tap', 'plane or point under the pointer'], ['F', 'all in view'],
  ['Q  O  V', 'camera: follow, orbit, from the top'], ['arrows with Shift', 'turn by keyboard; with PgUp, PgDn: closer'],
  ['space', 'play or pause'], ['← →', 'one frame; with Ctrl one second'], ['Home End', 'first and last frame'],
  ['+ −', 'faster, slower'], ['C', 'next colouring'],
  ['M H L J K E G B W', 'layers: map, horizon, planes, trajectory, keyframes, ellipsoids, grid, backs, wireframe'],
  ['D', 'measure between two points'], ['N', 'measure from a plane'], ['Esc', 'measure no more'],
  ['1 2 3 4', 'result A, B, both, beside each other'], ['X', 'between A and B'], ['P', 'save the picture'],
  ['T', 'dark or light'], ['?', 'this list'],
];

export function makeHelp(): HTMLDialogElement {
  const dialog = byId<HTMLDialogElement>('help');
  const rows = KEYS.map(([keys, meaning]) => make('tr', {},
    make('td', {}, ...keys.split(/ {2}/).flatMap((k) => [make('kbd', {}, k), ' '])), make('td', {}, meaning)));
  const close = make('button', { id: 'help-close' }, 'Close');
  close.addEventListener('click', () => dialog.close());
  dialog.replaceChildren(
    make('h1', {}, 'Keys, mouse and touch'), make('table', {}, ...rows),
    make('p', {}, 'Surfaces are shown from their front only, so that one looks into a room from outside; ' +
      '“Back sides” shows them all. Coordinates are those of the world W: z is up, the origin is the first pose.'),
    close);
  return dialog;
}
