// SPDX-License-Identifier: BSD-2-Clause
// node viewer/test/large_map.mjs FACET WORK [PICTURES]: a map of 500 000 faces in a browser that draws with the processor,
// at rest and while it turns. Prints pictures per second, and asserts what does not depend on the machine: fewer faces
// while it turns, all of them at rest, for picking and in the picture that is saved. FACET: the program; WORK: a folder to
// write to; PICTURES: a folder for screenshots. Exits with 77 where a browser or the packages are not there.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { findChromium, openBrowser, startProgram } from './program.mjs';

const [program, work, pictures] = process.argv.slice(2);
const TURNING_MS = 6000;

function skip(reason) {
  console.log(`large map: skipped, ${reason}`);
  process.exit(77);
}

const chromium = findChromium();
if (!chromium) skip('there is no Chromium; set CHROMIUM to one');
if (!existsSync(new URL('../node_modules/puppeteer-core', import.meta.url))) {
  skip("viewer/node_modules is not there; 'make viewer' installs it");
}

// ------------------------------------------------------------------ a hall of 25 x 15 x 3 m with one wall in it

const CELL = 0.05;

/** A rough patch of nu x nv squares, each two faces; its normal is u x v. */
function addPatch(mesh, corner, u, v, nu, nv) {
  const first = mesh.vertices.length;
  const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  for (let j = 0; j <= nv; j++) {
    for (let i = 0; i <= nu; i++) {
      const bump = 0.008 * Math.sin(1.7 * i + 0.3 * j) * Math.cos(0.9 * j - 0.4 * i);
      const p = [0, 1, 2].map((k) => corner[k] + CELL * (i * u[k] + j * v[k]) + bump * normal[k]);
      mesh.vertices.push({ p, normal, grey: 110 + Math.round(60 * Math.sin(0.11 * i) * Math.sin(0.13 * j)) });
    }
  }
  for (let j = 0; j < nv; j++) {
    for (let i = 0; i < nu; i++) {
      const a = first + j * (nu + 1) + i, b = a + 1, c = a + nu + 1, d = c + 1;
      mesh.faces.push([a, b, d, mesh.numPatches], [a, d, c, mesh.numPatches]);
    }
  }
  mesh.numPatches++;
}

function hall() {
  const mesh = { vertices: [], faces: [], numPatches: 0 };
  addPatch(mesh, [0, 0, 0], [1, 0, 0], [0, 1, 0], 500, 300);
  addPatch(mesh, [25, 0, 0], [-1, 0, 0], [0, 0, 1], 500, 60);
  addPatch(mesh, [0, 15, 0], [1, 0, 0], [0, 0, 1], 500, 60);
  addPatch(mesh, [0, 0, 0], [0, 1, 0], [0, 0, 1], 300, 60);
  addPatch(mesh, [25, 15, 0], [0, -1, 0], [0, 0, 1], 300, 60);
  addPatch(mesh, [14, 7, 0], [-1, 0, 0], [0, 0, 1], 80, 50);
  return mesh;
}

function writePly(file, { vertices, faces }) {
  const header = `ply\nformat binary_little_endian 1.0\nelement vertex ${vertices.length}\n` +
    ['x', 'y', 'z', 'nx', 'ny', 'nz'].map((name) => `property float ${name}\n`).join('') +
    ['red', 'green', 'blue'].map((name) => `property uchar ${name}\n`).join('') +
    `element face ${faces.length}\nproperty list uchar int vertex_indices\nproperty int plane_id\nend_header\n`;
  const bytes = Buffer.alloc(header.length + 27 * vertices.length + 17 * faces.length);
  let at = bytes.write(header, 'latin1');
  for (const { p, normal, grey } of vertices) {
    for (const value of [...p, ...normal]) at = bytes.writeFloatLE(value, at);
    for (let k = 0; k < 3; k++) at = bytes.writeUInt8(grey, at);
  }
  for (const face of faces) {
    at = bytes.writeUInt8(3, at);
    for (const value of face) at = bytes.writeInt32LE(value, at);
  }
  writeFileSync(file, bytes);
}

/** A result of a camera that flew through the hall. */
function writeResult(folder) {
  mkdirSync(folder, { recursive: true });
  const mesh = hall();
  writePly(join(folder, 'map.ply'), mesh);
  const poses = Array.from({ length: 200 }, (_, i) => `${(10 + 0.05 * i).toFixed(9)} ${2 + 0.1 * i} 5 1.5 0 0 0 1`);
  writeFileSync(join(folder, 'trajectory.tum'), `${poses.join('\n')}\n`);
  return mesh.faces.length;
}

// ------------------------------------------------------------------ the page

const stats = (page) => page.evaluate(() => window.facet.stats());

async function until(page, condition, what) {
  for (let i = 0; i < 600; i++) {
    const s = await page.evaluate(() => window.facet?.stats());
    if (s && condition(s)) return s;
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  throw new Error(`${what} did not come: ${JSON.stringify(await stats(page))}`);
}

/** Drags for a while; the page takes a drag when it draws. */
async function turn(page, durationMs) {
  await page.mouse.move(600, 400);
  await page.mouse.down();
  const first = await stats(page), begin = performance.now();
  let angle = 0, fewest = Infinity, last = first;
  while (performance.now() - begin < durationMs) {
    angle += 0.05;
    await page.mouse.move(640 + 200 * Math.cos(angle), 400 + 30 * Math.sin(angle));
    last = await stats(page);
    fewest = Math.min(fewest, last.triangles);
  }
  const perSecond = (1000 * (last.frames - first.frames)) / (performance.now() - begin);
  await page.mouse.up();
  return { perSecond, fewest };
}

/** While the picture is in motion: runs `action` in the page, and what the page draws right after it. */
async function inMotion(page, action) {
  await page.focus('#canvas');
  await page.keyboard.down('Shift');
  let s = await stats(page);
  for (let i = 0; i < 100 && !s.isCoarse; i++) {
    await page.keyboard.press('ArrowLeft');
    s = await stats(page);
  }
  const after = await page.evaluate((source) => {
    eval(source);
    return window.facet.stats();
  }, action);
  await page.keyboard.up('Shift');
  return after;
}

const folder = join(work, 'large_map');
rmSync(folder, { recursive: true, force: true });
const numFaces = writeResult(join(folder, 'hall'));
const server = await startProgram(program, ['view', join(folder, 'hall'), '--port', '0']);
const browser = await openBrowser(chromium);
try {
  const page = await browser.newPage();
  const problems = [];
  page.on('pageerror', (error) => problems.push(error.message));
  await page.setViewport({ width: 1280, height: 800 });
  await page.goto(server.url);
  const loaded = await until(page, (s) => s.triangles >= numFaces && s.fullPictureMs > 0, 'the whole map');
  assert.equal(loaded.faces[0].map, numFaces);
  await turn(page, 1500); // what is made once is made now
  const turning = await turn(page, TURNING_MS);
  if (pictures) await page.screenshot({ path: join(pictures, 'large_map_turning.png') });
  const rest = await until(page, (s) => !s.isCoarse && s.triangles >= numFaces, 'the picture at rest');
  if (pictures) await page.screenshot({ path: join(pictures, 'large_map_rest.png') });
  console.log(`${numFaces} faces are there after ${(loaded.firstMeshMs / 1000).toFixed(1)} s; while the picture turns: ` +
    `${turning.perSecond.toFixed(1)} pictures per second of ${turning.fewest} triangles; at rest ${rest.triangles} ` +
    `triangles in ${rest.fullPictureMs.toFixed(0)} ms`);
  if (loaded.fullPictureMs > rest.slowPictureMs) {
    assert.ok(turning.fewest < numFaces / 8, `${turning.fewest} triangles while it turns`);
    const saved = await inMotion(page, "document.getElementById('screenshot').click()");
    assert.ok(!saved.isCoarse && saved.triangles >= numFaces, `a picture was saved with ${saved.triangles} triangles`);
    await until(page, (s) => !s.isCoarse, 'rest');
    await page.click('#measure [data-value=points]');
    const picked = await inMotion(page, `for (const type of ['pointerdown', 'pointerup'])
      document.getElementById('canvas').dispatchEvent(new PointerEvent(type, { isPrimary: true, button: 0,
        clientX: 620, clientY: 400, pointerId: 1, bubbles: true }));`);
    assert.ok(!picked.isCoarse && picked.measure === 2, 'a point of the full mesh is picked');
  } else {
    console.log('all faces are drawn while it turns, too: this machine is fast enough');
  }
  assert.deepEqual(problems, []);
} finally {
  await browser.close();
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
}
