// SPDX-License-Identifier: BSD-2-Clause
// The 3D picture: cameras, lights and the objects of each source, in one view or two beside each other.
import {
  AmbientLight, Box3, BufferAttribute, BufferGeometry, Color, DirectionalLight, GridHelper, Group, Line,
  LineBasicMaterial, MOUSE, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, TOUCH, Vector2, Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { addSamples, distanceToSee } from './framing';
import { MeshObject, type Colouring, type ColourRange } from './mesh_object';
import type { Model, Plane, Source } from './model';
import { disposeAll, PathObject } from './path_object';
import { PlaneObjects } from './plane_object';

export type CameraMode = 'orbit' | 'follow' | 'top';
export type Arrangement = 'a' | 'b' | 'overlay' | 'side';
export type Layer =
  | 'map' | 'horizon' | 'planes' | 'landmarks' | 'trajectory' | 'keyframes' | 'ellipsoids' | 'frustum' | 'truth' | 'error'
  | 'grid' | 'backs' | 'edges';

export interface Hit {
  point: Vector3;
  planeId: number;
  source: number;
}

interface SourceObjects {
  group: Group;
  meshes: Map<string, MeshObject>;
  path: PathObject;
  planes: PlaneObjects;
  points: Points<BufferGeometry, PointsMaterial>;
}

const PATH_COLOURS = [
  { past: 0xd55e00, future: 0x8a929c, keyframe: 0xffb86b, truth: 0x009e73, frustum: 0x0072b2 },
  { past: 0xcc79a7, future: 0x8a929c, keyframe: 0xe8b5d2, truth: 0x009e73, frustum: 0x56b4e9 },
];

const RECOLOUR_PERIOD_MS = 1000;
// Where a picture of all faces takes longer than this, pictures in motion have fewer, until they are at rest for a moment.
const SLOW_PICTURE_MS = 90;
const REST_MS = 300;
const MANY_FACES = 150000;
const COARSE_FACES = 50000;

export class Stage {
  readonly camera = new PerspectiveCamera(50, 1, 0.02, 2000);
  readonly layers: Record<Layer, boolean> = {
    map: true, horizon: true, planes: true, landmarks: false, trajectory: true, keyframes: true, ellipsoids: true,
    frustum: true, truth: true, error: true, grid: true, backs: false, edges: false,
  };
  colouring: Colouring = 'plane';
  arrangement: Arrangement = 'overlay';
  cameraMode: CameraMode = 'orbit';
  range: ColourRange = { low: 0, high: 1 };
  numFrames = 0;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly controls: OrbitControls;
  private readonly headLight = new DirectionalLight(0xffffff, 1.7);
  private readonly sources: SourceObjects[] = [];
  private readonly measure = new Group();
  private grid: GridHelper;
  private isDirty = true;
  private framedBy: 'nothing' | 'path' | 'mesh' | 'user' = 'nothing';
  private lastRecolour = 0;
  private lastMotion = -Infinity;
  private fullPictureMs = 0;
  private drawing: { since: number; sync: WebGLSync } | null = null;
  private isCoarse = false;
  private layersBefore: { map: boolean; horizon: boolean } | null = null;
  private lastFollowed: Vector3 | null = null;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly overlay: HTMLElement,
    private readonly model: Model,
    private readonly onPlane: (plane: Plane) => void,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: false });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-6, -6, 5);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.PAN, RIGHT: MOUSE.PAN };
    this.controls.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.move());
    this.controls.addEventListener('start', () => (this.framedBy = 'user'));
    this.scene.add(new AmbientLight(0xffffff, 1.5), this.camera, this.measure);
    this.headLight.position.set(0.4, 0.6, 1);
    this.camera.add(this.headLight, this.headLight.target);
    this.headLight.target.position.set(0, 0, -1);
    this.grid = this.makeGrid();
    const render = (): void => {
      requestAnimationFrame(render);
      const now = performance.now();
      this.clockFullPicture(now);
      const isMoving = now - this.lastMotion < REST_MS;
      if (this.isCoarse && !isMoving) this.invalidate();
      if (!this.isDirty) return;
      this.setCoarse(isMoving && this.fullPictureMs > SLOW_PICTURE_MS);
      this.render();
      this.startClock(now);
    };
    requestAnimationFrame(render);
  }

  invalidate(): void {
    this.isDirty = true;
  }

  /** The next pictures are in motion: they may have fewer faces. */
  move(): void {
    this.lastMotion = performance.now();
    this.invalidate();
  }

  // Drawing ends long after the call that asks for it; a fence behind its commands says when.
  private startClock(now: number): void {
    if (this.isCoarse || this.drawing) return;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    if (sync) this.drawing = { since: now, sync };
  }

  private clockFullPicture(now: number): void {
    if (!this.drawing) return;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    if (gl.getSyncParameter(this.drawing.sync, gl.SYNC_STATUS) !== gl.SIGNALED) return;
    gl.deleteSync(this.drawing.sync);
    this.fullPictureMs = now - this.drawing.since;
    this.drawing = null;
  }

  private setCoarse(coarse: boolean): void {
    let num = 0;
    for (const s of this.sources) for (const m of s.meshes.values()) num += m.mesh.faces.length / 3;
    this.isCoarse = coarse && num > MANY_FACES;
    const edgesPerCell = this.isCoarse ? edgesPerCellFor(num) : 0;
    for (const s of this.sources) for (const m of s.meshes.values()) m.setCoarse(edgesPerCell);
    const ratio = Math.min(window.devicePixelRatio, this.isCoarse ? 1 : 2);
    if (this.renderer.getPixelRatio() === ratio) return;
    this.renderer.setPixelRatio(ratio); // empties the canvas
    this.invalidate();
  }

  // ------------------------------------------------------------------ what is shown

  reset(): void {
    for (const s of this.sources) {
      s.planes.dispose();
      for (const mesh of s.meshes.values()) mesh.dispose();
      disposeAll(s.group);
    }
    this.sources.length = 0;
    this.framedBy = 'nothing';
    this.model.sources.forEach((_, i) => this.sources.push(this.makeSource(i)));
    this.applyLayers();
  }

  private makeSource(i: number): SourceObjects {
    const objects: SourceObjects = {
      group: new Group(),
      meshes: new Map(),
      path: new PathObject(PATH_COLOURS[i % 2]!),
      planes: new PlaneObjects(this.overlay, this.onPlane),
      points: new Points(
        new BufferGeometry(), new PointsMaterial({ color: 0xe69f00, size: 3, sizeAttenuation: false })),
    };
    objects.points.frustumCulled = false;
    objects.group.add(objects.path.group, objects.planes.group, objects.points);
    this.scene.add(objects.group);
    return objects;
  }

  setMesh(i: number, name: string): void {
    const s = this.sources[i]!;
    s.meshes.get(name)?.dispose();
    s.meshes.delete(name);
    const mesh = this.model.sources[i]!.meshes.get(name);
    if (mesh) {
      const object = new MeshObject(mesh, i);
      s.meshes.set(name, object);
      object.bothSides = this.layers.backs;
      object.object.material.wireframe = this.layers.edges;
      object.recolour(this.colouring, this.range);
      s.group.add(object.object);
    }
    this.applyLayers();
  }

  setFrames(i: number): void {
    const { frames, errors } = this.source(i);
    this.sources[i]!.path.setFrames(frames, errors, this.model.largestError);
    this.invalidate();
  }

  setKeyframes(i: number): void {
    const { keyframes, truth } = this.source(i);
    if (keyframes) this.sources[i]!.path.setKeyframes(keyframes);
    if (truth) this.sources[i]!.path.setTruth(truth);
    this.invalidate();
  }

  setPlanes(i: number): void {
    this.sources[i]!.planes.set(this.source(i).planes);
    this.invalidate();
  }

  setPoints(i: number): void {
    this.sources[i]!.points.geometry.dispose(); // frees the buffer that is replaced
    this.sources[i]!.points.geometry.setAttribute('position', new BufferAttribute(this.source(i).points, 3));
    this.invalidate();
  }

  /** Shows the run as it was at the frame of each source; while it plays, the picture is in motion. */
  setMoment(indices: number[], isPlaying: boolean): void {
    indices.forEach((index, i) => {
      const s = this.sources[i];
      const frame = this.source(i).frames.at(index);
      if (!s || !frame) return;
      s.path.setCurrent(index);
      s.path.frustum.visible = frame.hasPose && this.layers.frustum;
      if (!frame.hasPose) return;
      s.path.setFrustum(frame.pose, this.source(i).hello.camera, 0.35);
      if (i === this.mainSource()) this.follow(new Vector3(frame.pose[0], frame.pose[1], frame.pose[2]));
    });
    if (isPlaying) this.move();
    else this.invalidate();
  }

  selectPlane(id: number | null): void {
    for (const s of this.sources) s.planes.selected = id;
    this.invalidate();
  }

  /** After meshes have come, which have the colours of the range so far: a growing map shifts it slowly. */
  updateRange(): void {
    this.invalidate();
    const hasRange = ['height', 'age', 'sigma', 'error'].includes(this.colouring);
    const isDue = this.model.mode === 'finished' || performance.now() - this.lastRecolour > RECOLOUR_PERIOD_MS;
    if (!hasRange || !isDue) return;
    this.lastRecolour = performance.now();
    this.recolour();
  }

  /** Only the horizon mesh knows how uncertain its vertices are: while that is shown, the map stands back. */
  choose(colouring: Colouring): void {
    if (colouring === this.colouring) return;
    if (colouring === 'sigma') {
      this.layersBefore = { map: this.layers.map, horizon: this.layers.horizon };
      Object.assign(this.layers, { map: false, horizon: true });
    } else if (this.layersBefore) {
      Object.assign(this.layers, this.layersBefore);
      this.layersBefore = null;
    }
    this.colouring = colouring;
    this.applyLayers();
    this.recolour();
  }

  recolour(): void {
    this.range = this.findRange();
    for (const s of this.sources) for (const m of s.meshes.values()) m.recolour(this.colouring, this.range);
    this.invalidate();
  }

  /** From the 2nd to the 98th percentile, so that stray points do not use up the colours. */
  private findRange(): ColourRange {
    const values: number[] = [];
    for (const s of this.sources) {
      for (const { mesh } of s.meshes.values()) {
        const n = mesh.positions.length / 3, step = Math.max(1, Math.floor(n / 5000));
        if (this.colouring === 'age') values.push(Number(mesh.stampNs / 1000000n) / 1e3);
        else for (let v = 0; v < n; v += step) {
          if (this.colouring === 'height') values.push(mesh.positions[3 * v + 2]!);
          if (this.colouring === 'sigma' && mesh.sigma.length > 0) values.push(mesh.sigma[v]!);
          if (this.colouring === 'error' && mesh.error.length > 0) values.push(mesh.error[v]!);
        }
      }
    }
    if (values.length === 0) return { low: 0, high: 1 };
    values.sort((a, b) => a - b);
    const low = values[Math.floor(0.02 * (values.length - 1))]!, high = values[Math.ceil(0.98 * (values.length - 1))]!;
    if (this.colouring === 'sigma' || this.colouring === 'error') return { low: 0, high: Math.max(high, 1e-3) };
    return { low, high: high > low ? high : low + 1 };
  }

  has(colouring: Colouring): boolean {
    if (colouring === 'source') return this.sources.length > 1;
    if (colouring === 'age') return this.model.mode === 'live';
    const meshes = this.model.sources.flatMap((s) => [...s.meshes.values()]);
    if (colouring === 'sigma') return meshes.some((m) => m.sigma.length > 0);
    if (colouring === 'error') return meshes.some((m) => m.error.length > 0);
    return true;
  }

  applyLayers(): void {
    const show = this.layers;
    this.sources.forEach((s, i) => {
      for (const [name, m] of s.meshes) {
        m.object.visible = name === 'horizon' ? show.horizon : show.map;
        m.bothSides = show.backs;
        m.object.material.wireframe = show.edges;
      }
      s.planes.group.visible = show.planes;
      s.points.visible = show.landmarks;
      s.path.line.visible = show.trajectory;
      s.path.keyframes.visible = show.keyframes;
      s.path.ellipsoidGroup.visible = show.ellipsoids;
      s.path.frustum.visible = show.frustum;
      s.path.truth.visible = show.truth;
      s.path.byError = show.error && this.model.sources[i]?.truth != null;
    });
    this.grid.visible = show.grid;
    this.invalidate();
  }

  setTheme(background: string, gridColour: string): void {
    this.scene.background = new Color(background);
    this.grid.removeFromParent();
    this.grid = this.makeGrid(gridColour);
    this.applyLayers();
  }

  private makeGrid(colour = '#888888'): GridHelper {
    const grid = new GridHelper(40, 40, colour, colour);
    grid.rotation.x = Math.PI / 2; // z is up
    grid.material.transparent = true;
    grid.material.opacity = 0.35;
    grid.position.z = this.floorHeight();
    this.scene.add(grid);
    return grid;
  }

  private floorHeight(): number {
    const floors = this.model.sources.flatMap((s) => s.planes).filter((p) => p.label === 'floor');
    const largest = floors.sort((a, b) => b.area_m2 - a.area_m2)[0];
    const box = this.bounds();
    return (largest ? largest.centre[2] : box.isEmpty() ? 0 : box.min.z) - 0.02;
  }

  // ------------------------------------------------------------------ cameras

  setCameraMode(mode: CameraMode): void {
    this.cameraMode = mode;
    this.controls.enableRotate = mode !== 'top';
    this.lastFollowed = null;
    if (mode !== 'follow') this.frameAll();
    this.invalidate();
  }

  bounds(): Box3 {
    return new Box3().setFromPoints(this.samples());
  }

  /** Points of the surfaces, without a few strays, and of the path. */
  private samples(): Vector3[] {
    const samples: Vector3[] = [];
    for (const s of this.model.sources) {
      for (const mesh of s.meshes.values()) addSamples(samples, mesh.positions);
      for (let i = 0; i < s.frames.count; i += 10) {
        const f = s.frames.at(i)!;
        if (f.hasPose) samples.push(new Vector3(f.pose[0], f.pose[1], f.pose[2]));
      }
    }
    return samples;
  }

  /** All of the scene in the picture, from the direction of the camera's mode. */
  frameAll(): void {
    const samples = this.samples();
    if (samples.length === 0) return;
    const centre = new Box3().setFromPoints(samples).getCenter(new Vector3());
    const direction = this.cameraMode === 'top' ? new Vector3(0, -1e-3, 1) : new Vector3(-0.55, -0.75, 0.75);
    const view = this.views()[0];
    const aspect = view ? view.width / Math.max(this.canvas.clientHeight, 1) : this.camera.aspect;
    const distance = distanceToSee(
      samples.map((p) => p.sub(centre)), direction.normalize(), 0.5 * this.camera.fov * (Math.PI / 180), aspect);
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(direction, distance);
    this.controls.update();
    this.grid.position.z = this.floorHeight();
    this.invalidate();
  }

  /** When there is something to see for the first time, unless the user has chosen a view. */
  frameFirst(): void {
    const hasMesh = this.sources.some((s) => s.meshes.size > 0);
    const by = hasMesh ? 'mesh' : 'path';
    if (this.framedBy === 'user' || this.framedBy === by || this.framedBy === 'mesh') return;
    this.frameAll();
    this.framedBy = by;
  }

  private follow(p: Vector3): void {
    if (this.cameraMode !== 'follow') return;
    if (this.lastFollowed) {
      const step = p.clone().sub(this.lastFollowed);
      this.camera.position.add(step);
    } else {
      const back = this.camera.position.clone().sub(this.controls.target).setLength(4.5);
      this.camera.position.copy(p).add(back);
    }
    this.controls.target.copy(p);
    this.lastFollowed = p.clone();
    this.controls.update();
  }

  /** By keyboard: turns by angles [rad], moves closer by a factor. */
  nudge(turn: number, tilt: number, closer: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(new Vector3(0, 0, 1), turn);
    const side = new Vector3(0, 0, 1).cross(offset).normalize();
    const angle = offset.angleTo(new Vector3(0, 0, 1)) + tilt;
    if (angle > 0.02 && angle < Math.PI - 0.02) offset.applyAxisAngle(side, tilt);
    offset.multiplyScalar(closer);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.invalidate();
  }

  // ------------------------------------------------------------------ picking

  pick(clientX: number, clientY: number): Hit | null {
    const rect = this.canvas.getBoundingClientRect();
    const view = this.views().find((v) =>
      clientX - rect.left >= v.x && clientX - rect.left < v.x + v.width);
    if (!view) return null;
    const at = new Vector2(
      (2 * (clientX - rect.left - view.x)) / view.width - 1, 1 - (2 * (clientY - rect.top)) / rect.height);
    this.setAspect(view.width / rect.height);
    this.setCoarse(false);
    const caster = new Raycaster();
    caster.setFromCamera(at, this.camera);
    const objects = view.sources.flatMap((i) =>
      [...this.sources[i]!.meshes.values()].map((m) => m.object).filter((o) => o.visible));
    const hit = caster.intersectObjects(objects, false)[0];
    if (!hit) return null;
    const owner = hit.object.userData['owner'] as MeshObject;
    return { point: hit.point, planeId: owner.planeOfFace(hit.faceIndex ?? -1), source: owner.source };
  }

  showMeasure(points: Vector3[]): void {
    disposeAll(this.measure);
    this.measure.clear();
    this.scene.add(this.measure);
    if (points.length > 0) {
      const geometry = new BufferGeometry().setFromPoints(points);
      const dots = new Points(geometry, new PointsMaterial({
        color: 0xf0e442, size: 10, sizeAttenuation: false, depthTest: false }));
      const line = new Line(geometry, new LineBasicMaterial({ color: 0xf0e442, depthTest: false }));
      dots.renderOrder = line.renderOrder = 10;
      dots.frustumCulled = line.frustumCulled = false;
      this.measure.add(dots, line);
    }
    this.invalidate();
  }

  // ------------------------------------------------------------------ rendering

  private source(i: number): Source {
    return this.model.sources[i]!;
  }

  private mainSource(): number {
    return this.arrangement === 'b' && this.sources.length > 1 ? 1 : 0;
  }

  private views(): { x: number; width: number; sources: number[] }[] {
    const width = this.canvas.clientWidth;
    if (this.sources.length < 2) return [{ x: 0, width, sources: this.sources.map((_, i) => i) }];
    switch (this.arrangement) {
      case 'a': return [{ x: 0, width, sources: [0] }];
      case 'b': return [{ x: 0, width, sources: [1] }];
      case 'overlay': return [{ x: 0, width, sources: [0, 1] }];
      case 'side': {
        const half = Math.floor(width / 2);
        return [{ x: 0, width: half, sources: [0] }, { x: half, width: width - half, sources: [1] }];
      }
    }
  }

  resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    if (this.framedBy === 'mesh' && this.cameraMode !== 'follow') this.frameAll();
    this.invalidate();
  }

  private setAspect(aspect: number): void {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
  }

  render(): void {
    this.isDirty = false;
    const height = this.canvas.clientHeight;
    if (height === 0 || this.canvas.clientWidth === 0) return;
    const target = this.renderer;
    target.setScissorTest(true);
    const seen = new Set<number>();
    for (const view of this.views()) {
      target.setViewport(view.x, 0, view.width, height);
      target.setScissor(view.x, 0, view.width, height);
      this.setAspect(view.width / height);
      this.camera.updateMatrixWorld();
      this.sources.forEach((s, i) => {
        s.group.visible = view.sources.includes(i);
        s.path.setResolution(view.width, height);
      });
      target.render(this.scene, this.camera);
      for (const i of view.sources) {
        seen.add(i);
        this.sources[i]!.planes.place(this.camera, view.x, 0, view.width, height, true);
      }
    }
    this.sources.forEach((s, i) => {
      if (!seen.has(i)) s.planes.place(this.camera, 0, 0, 0, 0, false);
    });
    this.numFrames++;
  }

  /** A PNG of what is shown. */
  async screenshot(): Promise<Blob> {
    this.setCoarse(false);
    this.render();
    return new Promise((resolve, reject) =>
      this.canvas.toBlob((b) => (b ? resolve(b) : reject(new Error('the picture could not be made'))), 'image/png'));
  }

  stats(): Record<string, unknown> {
    return {
      faces: this.sources.map((s) => {
        const counts: Record<string, number> = {};
        for (const [name, m] of s.meshes) {
          const kind = name.startsWith('map') ? 'map' : name;
          counts[kind] = (counts[kind] ?? 0) + m.mesh.faces.length / 3;
        }
        return counts;
      }),
      visible: this.sources.map((s) =>
        [...s.meshes.values()].filter((m) => m.object.visible).reduce((n, m) => n + m.mesh.faces.length / 3, 0)),
      pathColours: this.sources.map((s) => s.path.coloursShown()),
      segmentsShown: this.sources.map((s) => s.path.segmentsShown),
      ellipsoids: this.sources.map((s) => (s.path.ellipsoidGroup.visible ? s.path.ellipsoids?.count ?? 0 : 0)),
      labels: this.sources.map((s) => s.planes.numLabelsShown),
      keyframes: this.sources.map((s) =>
        s.path.keyframes.visible ? s.path.keyframes.geometry.getAttribute('position')?.count ?? 0 : 0),
      views: this.views().map((v) => v.sources),
      camera: this.camera.position.toArray(),
      target: this.controls.target.toArray(),
      colour: this.firstColour(),
      range: this.range,
      isCoarse: this.isCoarse,
      fullPictureMs: this.fullPictureMs,
      slowPictureMs: SLOW_PICTURE_MS,
      triangles: this.renderer.info.render.triangles,
      measure: this.measure.children.length,
      frames: this.numFrames,
      geometries: this.renderer.info.memory.geometries,
    };
  }

  private firstColour(): number[] {
    for (const s of this.sources) {
      for (const m of s.meshes.values()) return [...m.object.geometry.getAttribute('color').array.slice(0, 3)];
    }
    return [];
  }
}

/** In steps, so that a map that grows is not made anew again and again. */
function edgesPerCellFor(numFaces: number): number {
  // One and a half faces, about, for each square of a cell's side.
  const wanted = Math.sqrt((1.5 * numFaces) / COARSE_FACES);
  return 3 * Math.max(1, 2 ** (0.5 * Math.ceil(2 * Math.log2(wanted / 3))));
}
