// SPDX-License-Identifier: BSD-2-Clause
// Outlines of planes, and labels over the picture that name them: colour is never the only sign.
import {
  BufferAttribute, BufferGeometry, Camera, Color, Group, LineBasicMaterial, LineLoop, Vector3,
} from 'three';
import type { Plane } from './model';
import { css, planeColour } from './palette';

const MAX_LABELS = 24;

export class PlaneObjects {
  readonly group = new Group();
  selected: number | null = null;
  private planes: Plane[] = [];
  private labels: { element: HTMLButtonElement; plane: Plane }[] = [];

  constructor(private readonly overlay: HTMLElement, private readonly onSelect: (plane: Plane) => void) {}

  set(planes: Plane[]): void {
    this.group.traverse((o) => (o instanceof LineLoop ? o.geometry.dispose() : undefined));
    this.group.clear();
    this.labels.forEach((l) => l.element.remove());
    this.planes = [...planes].sort((a, b) => b.area_m2 - a.area_m2);
    for (const plane of this.planes) this.addOutline(plane);
    this.labels = this.planes.slice(0, MAX_LABELS).map((plane) => ({ plane, element: this.makeLabel(plane) }));
  }

  private addOutline(plane: Plane): void {
    if (plane.outline.length < 3) return;
    const lift = 0.005; // in front of the surface
    const points = new Float32Array(plane.outline.flatMap((p) => p.map((x, k) => x + lift * plane.n[k]!)));
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(points, 3));
    const colour = new Color(css(planeColour(plane.id)));
    const outline = new LineLoop(geometry, new LineBasicMaterial({ color: colour }));
    outline.userData['plane'] = plane.id;
    this.group.add(outline);
  }

  private makeLabel(plane: Plane): HTMLButtonElement {
    const element = document.createElement('button');
    element.className = 'label';
    element.textContent = `${plane.label} ${plane.id}`;
    element.style.borderColor = css(planeColour(plane.id));
    element.title = describePlane(plane);
    element.addEventListener('click', () => this.onSelect(plane));
    this.overlay.append(element);
    return element;
  }

  /** Moves the labels to where their planes are; of those that would overlap the larger plane's stays. */
  place(camera: Camera, left: number, top: number, width: number, height: number, sourceIsShown: boolean): void {
    const taken: DOMRect[] = [];
    for (const { element, plane } of this.labels) {
      const p = new Vector3(...plane.centre).project(camera);
      const x = left + (0.5 + 0.5 * p.x) * width, y = top + (0.5 - 0.5 * p.y) * height;
      // Half of the size of a label, about.
      const box = new DOMRect(x - 34, y - 11, 68, 22);
      const isIn = p.z < 1 && box.left > left && box.right < left + width && box.top > top && box.bottom < top + height;
      const isFree = taken.every((t) =>
        box.right < t.left || box.left > t.right || box.bottom < t.top || box.top > t.bottom);
      const isShown = this.group.visible && sourceIsShown && isIn && isFree;
      element.hidden = !isShown;
      if (!isShown) continue;
      taken.push(box);
      element.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px) translate(-50%, -50%)`;
      element.classList.toggle('selected', plane.id === this.selected);
    }
  }

  get numLabelsShown(): number {
    return this.labels.filter((l) => !l.element.hidden).length;
  }

  dispose(): void {
    this.set([]);
    this.group.removeFromParent();
  }
}

export function describePlane(plane: Plane): string {
  const sigma = plane.sigma_d_m > 0
    ? `, ${(100 * plane.sigma_d_m).toFixed(1)} cm and ${((180 / Math.PI) * plane.sigma_normal_rad).toFixed(2)}° (1 sigma)`
    : '';
  return `Plane ${plane.id}, ${plane.label} (${plane.orientation}): ${plane.area_m2.toFixed(1)} m²${sigma}, ` +
    `${plane.landmarks} landmarks`;
}
