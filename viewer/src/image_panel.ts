// SPDX-License-Identifier: BSD-2-Clause
// What the left camera sees: tracks, coloured by depth, and the triangles between them.
import { byId, colourOf, make } from './dom';
import type { CameraImage } from './model';
import { amountColour, AMOUNT_GRADIENT, css, planeColour } from './palette';

type Choice = 'tracks' | 'triangles';

export class ImagePanel {
  numTracks = 0;
  numTriangles = 0;
  stampNs = 0n;
  private readonly canvas = make('canvas', { id: 'camera-image', 'aria-label': 'Image of the left camera' });
  private readonly show: Record<Choice, boolean> = { tracks: true, triangles: true };
  private readonly legend = make('div', { class: 'legend' });
  private tracksOption = make('label');
  private image: CameraImage | null = null;
  private bitmap: ImageBitmap | null = null;
  private isDecoding = false;

  constructor() {
    const options = make('div', { class: 'options' });
    const names: [Choice, string][] = [['tracks', 'Tracks by depth'], ['triangles', 'Triangles']];
    for (const [choice, text] of names) {
      const box = make('input', { type: 'checkbox', id: `image-${choice}` });
      box.checked = true;
      box.addEventListener('change', () => {
        this.show[choice] = box.checked;
        this.draw();
      });
      const label = make('label', {}, box, text);
      options.append(label);
      if (choice === 'tracks') this.tracksOption = label;
    }
    byId('image').append(this.canvas, options, this.legend);
  }

  async set(image: CameraImage): Promise<void> {
    this.image = image;
    byId('image').hidden = false;
    if (this.isDecoding) return; // the newest one is taken when this is done
    this.isDecoding = true;
    try {
      while (this.image && this.image.stampNs !== this.stampNs) {
        const newest: CameraImage = this.image;
        const bitmap = await createImageBitmap(new Blob([newest.jpeg.slice()], { type: 'image/jpeg' }));
        this.bitmap?.close();
        this.bitmap = bitmap;
        this.stampNs = newest.stampNs;
        this.drawWith(newest);
      }
    } finally {
      this.isDecoding = false;
    }
  }

  draw(): void {
    if (this.image) this.drawWith(this.image);
  }

  private drawWith(image: CameraImage): void {
    const bitmap = this.bitmap;
    if (!bitmap) return;
    this.canvas.width = bitmap.width;
    this.canvas.height = bitmap.height;
    const context = this.canvas.getContext('2d')!;
    context.drawImage(bitmap, 0, 0);
    const { pixels, depths, triangles } = image;
    const known = [...depths].filter((d) => d > 0).sort((a, b) => a - b);
    const near = known[Math.floor(0.05 * known.length)] ?? 0.5;
    const far = Math.max(known[Math.floor(0.95 * known.length)] ?? 10, near + 0.1);
    this.numTracks = this.show.tracks && !image.of ? pixels.length / 2 : 0;
    this.numTriangles = this.show.triangles ? triangles.length / 3 : 0;
    if (this.show.triangles) {
      const byPlane = new Map<number, Path2D>();
      for (let t = 0; t < triangles.length; t += 3) {
        const id = image.planeIds[t / 3] ?? 0; // one colour where planes are not known
        const path = byPlane.get(id) ?? new Path2D();
        byPlane.set(id, path);
        for (let k = 0; k < 4; k++) {
          const corner = triangles[t + (k % 3)]!;
          const x = pixels[2 * corner]!, y = pixels[2 * corner + 1]!;
          if (k === 0) path.moveTo(x, y);
          else path.lineTo(x, y);
        }
      }
      context.lineWidth = 1;
      context.globalAlpha = image.of ? 0.8 : 0.55;
      for (const [id, path] of byPlane) {
        context.strokeStyle = css(planeColour(id));
        context.stroke(path);
      }
      context.globalAlpha = 1;
    }
    if (this.numTracks > 0) {
      for (let i = 0; i < depths.length; i++) {
        const depth = depths[i]!;
        const isKnown = depth > 0;
        // By inverse depth, as the camera measures it: near is bright.
        context.fillStyle = isKnown ? css(amountColour((1 / depth - 1 / far) / (1 / near - 1 / far))) : 'transparent';
        context.strokeStyle = isKnown ? 'rgb(0 0 0 / 60%)' : '#fff';
        context.lineWidth = 1;
        context.beginPath();
        context.arc(pixels[2 * i]!, pixels[2 * i + 1]!, isKnown ? 3.5 : 2.5, 0, 2 * Math.PI);
        context.fill();
        context.stroke();
      }
    }
    this.legend.replaceChildren(
      make('div', { class: 'bar', style: `background:${AMOUNT_GRADIENT}` }),
      make('div', { class: 'ends' }, make('span', {}, `${far.toFixed(1)} m`), make('span', {}, 'depth'),
        make('span', {}, `${near.toFixed(1)} m`)),
      make('div', { style: `color:${colourOf('--soft')}` },
        `${pixels.length / 2} points, ${triangles.length / 3} triangles; hollow: depth not known yet`),
    );
    // Over the image of a finished run lies the mesh, which has no tracks.
    this.tracksOption.hidden = image.of !== '';
    if (!image.of) return;
    this.legend.replaceChildren(make('div', { style: `color:${colourOf('--soft')}` },
      `${triangles.length / 3} faces of ${image.of} that the camera sees, coloured by plane`));
  }
}
