// SPDX-License-Identifier: BSD-2-Clause
// node viewer/test/run.mjs FACET WORK DATA [PICTURES]: the page in a browser without a display, against what the result
// files say. FACET: the program; WORK: a folder to write to; DATA: where the recordings are; PICTURES: a folder for
// screenshots; ONLY, in the environment: a part of the names of the tests to run. Exits with 77 where a browser, the
// packages or the recording are not there.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { findChromium, openBrowser, runProgram, startProgram } from './program.mjs';

const [program, work, data, pictures] = process.argv.slice(2);

function skip(reason) {
  console.log(`viewer: skipped, ${reason}`);
  process.exit(77);
}

const chromium = findChromium();
if (!chromium) skip('there is no Chromium; set CHROMIUM to one');
if (!existsSync(new URL('../node_modules/puppeteer-core', import.meta.url))) {
  skip("viewer/node_modules is not there; 'make viewer' installs it");
}
const recording = join(data, 'rendered_room');
if (!existsSync(recording)) skip(`no recorded data "rendered_room" in ${data}: set FACET_DATA_DIR`);

// ------------------------------------------------------------------ what the files say

function csv(file) {
  const [head, ...rows] = readFileSync(file, 'utf8').trim().split('\n').map((line) => line.split(','));
  return rows.map((row) => Object.fromEntries(head.map((name, i) => [name, row[i]])));
}

function facesOf(ply) {
  return Number(/element face (\d+)/.exec(readFileSync(ply, 'latin1').slice(0, 2000))[1]);
}

/** The 1-sigma of each vertex, which stands beside the mesh. */
function sigmasOf(ply) {
  const [head, ...lines] = readFileSync(ply.replace('/meshes/', '/mesh_sigmas/').replace(/ply$/, 'sigma'), 'utf8').trim().split('\n');
  assert.equal(head, 'sigma_m');
  assert.equal(lines.length, Number(/element vertex (\d+)/.exec(readFileSync(ply, 'latin1'))[1]));
  return lines.map(Number);
}

function near(actual, expected, tolerance, what) {
  assert.ok(Math.abs(actual - expected) <= tolerance, `${what}: ${actual} instead of ${expected}`);
}

// ------------------------------------------------------------------ the page

async function open(browser, url, width, height, touch = false) {
  const page = await browser.newPage();
  page.problems = [];
  page.on('pageerror', (error) => page.problems.push(error.message));
  page.on('console', (m) => { if (m.type() === 'error') page.problems.push(m.text()); });
  await page.setViewport({ width, height, hasTouch: touch, isMobile: touch });
  await page.goto(url);
  page.stats = () => page.evaluate(() => window.facet.stats());
  page.until = async (condition, what) => {
    for (let i = 0; i < 600; i++) {
      const stats = await page.evaluate(() => window.facet?.stats());
      if (stats && condition(stats)) return stats;
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
    throw new Error(`${what} did not come: ${JSON.stringify(await page.stats())}`);
  };
  page.shot = async (name) => {
    if (!pictures) return;
    mkdirSync(pictures, { recursive: true });
    await page.screenshot({ path: join(pictures, `${name}.png`) });
  };
  return page;
}

async function drawn(page) {
  const { frames } = await page.stats();
  await page.evaluate(() => window.dispatchEvent(new Event('resize')));
  return page.until((s) => s.frames >= frames, 'a picture');
}

const tests = [];
const test = (name, body) => tests.push([name, body]);

test('a finished result is shown as its files say', async (browser, { url, result }) => {
  const page = await open(browser, url, 1280, 800);
  const s = await page.until((x) => x.faces[0]?.map > 0 && x.planeIds[0].length > 0 && x.labels[0] > 0, 'the map');
  assert.equal(s.mode, 'finished');
  assert.equal(s.faces[0].map, facesOf(join(result, 'map.ply')));
  const states = csv(join(result, 'states.csv'));
  assert.equal(s.frameCounts[0], states.length);
  assert.equal(s.stampNs, states.at(-1).timestamp_ns);
  assert.deepEqual(s.planeIds[0], csv(join(result, 'planes.csv')).map((p) => Number(p.id)));
  const keyframes = readFileSync(join(result, 'keyframes.tum'), 'utf8').trim().split('\n');
  assert.equal(s.keyframeCounts[0], keyframes.filter((l) => !l.startsWith('#')).length);
  assert.ok(s.truthCounts[0] > 100);
  const pose = await page.evaluate(() => window.facet.pose());
  ['px', 'py', 'pz', 'qw', 'qx', 'qy', 'qz'].forEach((name, i) => near(pose[i], states.at(-1)[name], 1e-5, name));
  console.log(`  first mesh after ${(s.firstMeshMs / 1000).toFixed(2)} s`);
  assert.equal(s.errors.length, 0);
  assert.deepEqual(page.problems, []);
  await page.shot('finished_1280');
  await page.close();
});

test('time is played, stepped and sought', async (browser, { url, result }) => {
  const page = await open(browser, url, 1280, 800);
  await page.until((x) => x.faces[0]?.map > 0 && x.frameCounts[0] > 0 && x.messages > 10, 'the result');
  const states = csv(join(result, 'states.csv'));
  await page.focus('#canvas');
  await page.keyboard.press('Home');
  assert.equal((await page.stats()).indices[0], 0);
  await page.click('#on');
  await page.keyboard.press('ArrowRight');
  assert.equal((await page.stats()).stampNs, states[2].timestamp_ns);
  await page.click('#back');
  assert.equal((await page.stats()).indices[0], 1);
  const seconds = 3;
  await page.$eval('#seek', (slider, value) => {
    slider.value = value;
    slider.dispatchEvent(new Event('input'));
  }, String(seconds));
  const index = states.findLastIndex((x) => BigInt(x.timestamp_ns) <= BigInt(states[0].timestamp_ns) + 3000000000n);
  const s = await page.until((x) => x.indices[0] === index, 'the sought frame');
  const pose = await page.evaluate(() => window.facet.pose());
  near(pose[0], states[index].px, 1e-5, 'px');
  // The path is drawn up to there: one segment less than poses.
  assert.equal(s.segmentsShown[0], states.slice(0, index + 1).filter((x) => x.px !== '').length - 1);
  const meshes = await page.until((x) => x.horizonStamps[0] !== '' && BigInt(x.horizonStamps[0]) <= BigInt(x.stampNs),
    'the horizon mesh of that moment');
  assert.equal(meshes.faces[0].horizon, facesOf(join(result, 'meshes', `${meshes.horizonStamps[0]}.ply`)));
  await page.select('#speed', '4');
  assert.equal((await page.stats()).speed, 4);
  await page.click('#play');
  await page.until((x) => x.isPlaying && x.indices[0] > index + 10, 'the playing');
  await page.click('#play');
  assert.equal((await page.stats()).isPlaying, false);
  await page.keyboard.press('End');
  assert.equal((await page.stats()).indices[0], states.length - 1);
  assert.match(await page.$eval('#values', (e) => e.textContent), /Gyro bias/);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('layers, colours and cameras change the picture', async (browser, { url, result }) => {
  const page = await open(browser, url, 1280, 800);
  const first = await page.until((x) => x.faces[0]?.map > 0 && x.ellipsoids[0] > 0 && x.keyframes[0] > 0, 'the result');
  await page.click('#layer-map');
  assert.equal((await page.stats()).visible[0], 0);
  await page.click('#layer-horizon');
  assert.equal((await page.stats()).visible[0], first.faces[0].horizon);
  await page.click('#layer-map');
  await page.click('#layer-horizon');
  await page.click('#layer-ellipsoids');
  await page.click('#layer-keyframes');
  const without = await page.stats();
  assert.equal(without.ellipsoids[0], 0);
  assert.equal(without.keyframes[0], 0);
  const labels = without.labels[0];
  await page.click('#layer-planes');
  await page.until((x) => x.labels[0] === 0 && labels > 0, 'no labels');
  await page.click('#layer-planes');
  for (const layer of ['trajectory', 'frustum', 'truth', 'grid', 'backs', 'edges', 'landmarks']) {
    const before = (await page.stats()).layers[layer];
    await page.click(`#layer-${layer}`);
    assert.equal((await page.stats()).layers[layer], !before, layer);
    await page.click(`#layer-${layer}`);
  }
  const colours = new Set();
  for (const colour of ['plane', 'normal', 'height', 'image', 'error']) {
    await page.select('#colour', colour);
    const s = await page.stats();
    assert.equal(s.colouring, colour);
    colours.add(String(s.colour));
    if (colour === 'error') assert.match(await page.$eval('#legend', (e) => e.textContent), /cm/);
    await drawn(page);
    await page.shot(`colour_${colour}`);
  }
  assert.ok(colours.size >= 4, 'each colouring colours differently');
  const { horizonStamps } = await page.until((x) => existsSync(join(result, 'meshes', `${x.horizonStamps[0]}.ply`)),
    'the horizon mesh of the end');
  const sigmas = sigmasOf(join(result, 'meshes', `${horizonStamps[0]}.ply`)).sort((a, b) => a - b);
  await page.select('#colour', 'sigma');
  const uncertain = await drawn(page);
  assert.equal(uncertain.visible[0], uncertain.faces[0].horizon, 'the horizon mesh alone');
  assert.equal(uncertain.layers.map, false);
  near(uncertain.range.high, sigmas[Math.ceil(0.98 * (sigmas.length - 1))], 1e-6, 'the end of the colours');
  assert.match(await page.$eval('#legend', (e) => e.textContent), /1-sigma/);
  await page.shot('colour_sigma');
  await page.select('#colour', 'plane');
  assert.equal((await page.stats()).layers.map, true);
  await page.click('#camera [data-value=top]');
  const top = await page.stats();
  assert.ok(top.camera[2] > top.target[2] + 2 && Math.abs(top.camera[0] - top.target[0]) < 0.1, 'from above');
  await page.click('#camera [data-value=follow]');
  const follow = await page.stats(), pose = await page.evaluate(() => window.facet.pose());
  near(follow.target[0], pose[0], 1e-4, 'the followed place');
  await page.click('#camera [data-value=orbit]');
  const before = (await page.stats()).camera;
  await page.mouse.move(600, 400);
  await page.mouse.down();
  await page.mouse.move(700, 420, { steps: 4 });
  await page.mouse.up();
  assert.notDeepEqual((await page.stats()).camera, before);
  await page.click('#frame');
  await page.click('#theme');
  const theme = await page.$eval('html', (e) => e.dataset.theme);
  await page.click('#theme');
  assert.notEqual(await page.$eval('html', (e) => e.dataset.theme), theme);
  await page.click('#help-open');
  assert.ok(await page.$eval('#help', (e) => e.open));
  await page.click('#help-close');
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('the path is coloured by its error, which is that of facet evaluate', async (browser, { url, result }) => {
  const page = await open(browser, url, 1280, 800);
  const s = await page.until((x) => x.largestErrors[0] > 0 && x.pathColours[0].length > 100, 'the errors');
  const { ate } = JSON.parse(readFileSync(join(result, 'evaluation.json'), 'utf8'));
  near(s.largestErrors[0], ate.max_m, 2e-6, 'the largest error');
  assert.equal(s.pathColours[0].length, s.segmentsShown[0]);
  const brightest = s.pathColours[0].reduce((a, b) => (b[0] > a[0] ? b : a));
  [253, 231, 37].forEach((c, k) => near(brightest[k], c, 1, 'the colour of the largest error'));
  const text = `${(1000 * ate.max_m).toFixed(1)} mm`;
  assert.ok((await page.$eval('#error-legend', (e) => e.textContent)).includes(text));
  assert.match(await page.$eval('#values', (e) => e.textContent), new RegExp(`Largest so far${text}`));
  assert.match(await page.$eval('#values', (e) => e.textContent),
    new RegExp(`Error${(1000 * s.errorNow[0]).toFixed(1)} mm`));
  await page.shot('path_error');
  await page.click('#layer-error');
  assert.deepEqual((await page.stats()).pathColours, [[]]);
  assert.ok(await page.$eval('#error-legend', (e) => e.hidden));
  await page.close();
});

test('the recorded image of the moment has the mesh over it', async (browser, { url, result }) => {
  const page = await open(browser, url, 1280, 900);
  const states = csv(join(result, 'states.csv'));
  const last = await page.until((x) => x.image.stampNs === states.at(-1).timestamp_ns, 'the last image');
  assert.ok(last.image.triangles > 50 && last.image.tracks === 0, JSON.stringify(last.image));
  assert.ok(last.image.triangles < facesOf(join(result, 'meshes', `${last.horizonStamps[0]}.ply`)));
  assert.match(await page.$eval('#image', (e) => e.textContent),
    new RegExp(`${last.image.triangles} faces of the horizon mesh`));
  await page.shot('recorded_image');
  await page.$eval('#seek', (slider) => {
    slider.value = '7';
    slider.dispatchEvent(new Event('input'));
  });
  const index = (await page.stats()).indices[0];
  const s = await page.until((x) => x.image.stampNs === states[index].timestamp_ns, 'the sought image');
  assert.notEqual(s.image.triangles, last.image.triangles);
  const size = await page.$eval('#camera-image', (c) => [c.width, c.height]);
  assert.deepEqual(size, [752, 480]);
  assert.equal(s.errors.length, 0);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('planes are chosen and distances measured', async (browser, { url, result }) => {
  const page = await open(browser, url, 1280, 800);
  await page.until((x) => x.faces[0]?.map > 0 && x.labels[0] > 0, 'the labels');
  const planes = csv(join(result, 'planes.csv')).sort((a, b) => b.area_m2 - a.area_m2);
  await page.click(`#plane-list [data-plane="${planes[0].id}"]`);
  assert.equal((await page.stats()).selected, Number(planes[0].id));
  assert.match(await page.$eval('#card', (e) => e.textContent), new RegExp(planes[0].label));
  await page.click('#camera [data-value=top]');
  await page.click('#measure [data-value=points]');
  const box = await (await page.$('#canvas')).boundingBox();
  const centre = [box.x + box.width / 2, box.y + box.height / 2];
  const spots = [];
  for (let i = 0; i < 60 && (await page.stats()).distance === null; i++) {
    const spot = [centre[0] + 9 * (i % 8) - 30, centre[1] + 12 * Math.floor(i / 8) - 30];
    await page.mouse.click(...spot);
    if ((await page.stats()).measure > 0) spots.push(spot);
  }
  const measured = await page.stats();
  assert.ok(measured.distance > 0 && measured.distance < 3, `distance ${measured.distance}`);
  assert.equal(measured.measure, 2);
  await page.shot('measure');
  const floor = planes.find((p) => p.label === 'floor');
  await page.click('#measure [data-value=plane]');
  await page.click(`#plane-list [data-plane="${floor.id}"]`);
  assert.equal((await page.stats()).distance, null);
  await page.mouse.click(...spots[0]);
  const toPlane = (await page.stats()).distance;
  assert.ok(toPlane !== null && Math.abs(toPlane) < 3, `to the plane ${toPlane}`);
  await page.keyboard.press('Escape');
  assert.equal((await page.stats()).measureMode, 'off');
  await page.close();
});

test('files and pictures are saved', async (browser, { url, result }) => {
  const page = await open(browser, url, 1280, 800);
  await page.until((x) => x.faces[0]?.map > 0, 'the map');
  await page.click('#downloads summary');
  const links = await page.$$eval('#downloads a', (list) => list.map((a) => a.getAttribute('href')));
  assert.ok(links.includes('download/a/map.ply') && links.includes('download/a/map.glb'));
  const bytes = await page.evaluate(async () => (await (await fetch('download/a/map.ply')).arrayBuffer()).byteLength);
  assert.equal(bytes, readFileSync(join(result, 'map.ply')).length);
  const glb = await page.evaluate(async () => (await (await fetch('download/a/map.glb')).text()).slice(0, 4));
  assert.equal(glb, 'glTF');
  const saved = await page.evaluate(() => new Promise((resolve) => {
    const makeUrl = URL.createObjectURL;
    let size = 0;
    URL.createObjectURL = (blob) => {
      size = blob.size;
      return makeUrl(blob);
    };
    HTMLAnchorElement.prototype.click = function () { resolve({ name: this.download, size }); };
    document.getElementById('screenshot').click();
  }));
  assert.equal(saved.name, 'facet.png');
  assert.ok(saved.size > 10000, `a picture of ${saved.size} bytes`);
  await page.close();
});

test('damaged messages are named and change nothing', async (browser, { url }) => {
  const page = await open(browser, url, 1280, 800);
  const before = await page.until((x) => x.faces[0]?.map > 0 && x.messages > 10, 'the result');
  for (const damage of ['flip', 'cut', 'magic', 'empty', 'version']) {
    await page.evaluate(async (kind) => {
      const socket = new WebSocket(new URL('live', location.href).href.replace('http', 'ws'));
      socket.binaryType = 'arraybuffer';
      let bytes = await new Promise((resolve) => (socket.onmessage = (e) => resolve(e.data)));
      socket.close();
      const view = new Uint8Array(bytes);
      if (kind === 'flip') view[view.length - 9] ^= 1;
      if (kind === 'cut') bytes = bytes.slice(0, bytes.byteLength - 8);
      if (kind === 'magic') view[0] ^= 1;
      if (kind === 'empty') bytes = new ArrayBuffer(0);
      if (kind === 'version') view[4] += 1;
      window.facet.receive(bytes);
    }, damage);
  }
  const after = await page.stats();
  assert.equal(after.errors.length, 5);
  assert.match(after.errors[0], /checksum/);
  assert.match(after.errors[1], /cut off/);
  assert.match(after.errors[4], /version/);
  assert.ok(await page.$eval('#message', (e) => !e.hidden));
  assert.deepEqual(after.faces, before.faces);
  await page.shot('damaged');
  await page.close();
});

test('it fits a phone and works by touch', async (browser, { url }) => {
  const page = await open(browser, url, 390, 844, true);
  await page.until((x) => x.faces[0]?.map > 0 && x.labels[0] > 0, 'the map');
  await page.until((x) => x.image.stampNs !== '0', 'the image');
  for (const tab of ['none', 'layers', 'colouring', 'planes', 'state', 'image', 'timing']) {
    await page.tap(`#tabs [data-tab=${tab}]`);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= 390, `${tab}: ${wide} px wide`);
    const size = await page.$eval('#canvas', (c) => [c.clientWidth, c.clientHeight]);
    assert.ok(size[0] === 390 && size[1] > 200, `${tab}: the picture has ${size}`);
    await drawn(page);
    await page.shot(`phone_${tab}`);
  }
  await page.tap('#tabs [data-tab=layers]');
  await page.tap('#layer-map');
  assert.equal((await page.stats()).visible[0], 0);
  await page.tap('#tabs [data-tab=none]');
  const before = (await page.stats()).camera;
  await page.touchscreen.touchStart(150, 400);
  await page.touchscreen.touchMove(220, 420);
  await page.touchscreen.touchMove(260, 430);
  await page.touchscreen.touchEnd();
  assert.notDeepEqual((await page.stats()).camera, before);
  assert.deepEqual(page.problems, []);
  await page.close();
});

test('what does not fit the height of the window is scrolled to', async (browser, { url }) => {
  for (const height of [900, 500]) {
    const page = await open(browser, url, 1280, height);
    await page.until((x) => x.faces[0]?.map > 0 && x.frameCounts[0] > 0 && x.messages > 10, 'the result');
    for (const side of ['#left', '#right']) {
      const bottom = await page.$eval(side, (panel) => {
        panel.scrollTop = panel.scrollHeight;
        const last = panel.querySelector('section:last-of-type').lastElementChild.getBoundingClientRect();
        return { last: last.bottom, panel: panel.getBoundingClientRect().bottom, overflow: panel.scrollTop };
      });
      assert.ok(bottom.last <= bottom.panel, `${side} at ${height} px: ends ${bottom.last - bottom.panel} px below`);
      if (height === 500) assert.ok(bottom.overflow > 0, `${side} is scrolled`);
    }
    await page.shot(`height_${height}`);
    await page.close();
  }
});

test('the end of a run that ends with its page reaches it', async (browser, { folder }) => {
  const out = join(folder, 'short');
  const server = await startProgram(program,
    ['run', recording, '--out', out, '--view=0', '--view-exit', '--realtime', '--duration', '4', '--quiet']);
  const page = await open(browser, server.url, 1280, 800);
  await page.until((x) => x.mode === 'live' && x.frameCounts[0] > 0, 'the run');
  assert.equal(await server.exited, 0);
  const s = await page.until((x) => x.ended !== null && x.faces[0]?.map > 0, 'the end');
  assert.equal(s.mode, 'finished');
  assert.equal(s.faces[0].map, facesOf(join(out, 'map.ply')));
  assert.equal(s.frameCounts[0], csv(join(out, 'states.csv')).length);
  await page.until((x) => x.connection !== 'connected', 'the loss of the connection');
  assert.equal(await page.$eval('#connection', (e) => e.textContent), 'run ended');
  await page.close();
});

test('two results stand beside and over each other', async (browser, { result, resultS }) => {
  const server = await startProgram(program, ['view', result, resultS, '--port', '0']);
  const page = await open(browser, server.url, 1280, 800);
  const s = await page.until((x) => x.faces[0]?.map > 0 && x.faces[1]?.map > 0 && x.frameCounts[1] > 0, 'both');
  assert.deepEqual(s.views, [[0], [1]]);
  assert.equal(s.faces[1].map, facesOf(join(resultS, 'map.ply')));
  await drawn(page);
  await page.shot('side_by_side');
  await page.click('#arrangement [data-value=overlay]');
  assert.deepEqual((await page.stats()).views, [[0, 1]]);
  await page.select('#colour', 'source');
  await drawn(page);
  await page.shot('overlay');
  await page.keyboard.press('x');
  assert.deepEqual((await page.stats()).views, [[0]]);
  await page.keyboard.press('x');
  assert.deepEqual((await page.stats()).views, [[1]]);
  await page.keyboard.press('4');
  assert.deepEqual((await page.stats()).views, [[0], [1]]);
  assert.deepEqual(page.problems, []);
  await page.close();
  assert.equal(await server.stop(), 0);
});

test('a run is shown while it goes on, and its result after it', async (browser, { folder }) => {
  const out = join(folder, 'live');
  const server = await startProgram(program,
    ['run', recording, '--out', out, '--view=0', '--realtime', '--duration', '9', '--quiet']);
  const page = await open(browser, server.url, 1280, 800);
  const early = await page.until((x) => x.mode === 'live' && x.faces[0]?.horizon > 0 && x.image.tracks > 20, 'the mesh');
  assert.equal(early.connection, 'connected');
  assert.ok(early.image.triangles > 20);
  assert.equal(early.cameraMode, 'follow');
  const later = await page.until((x) => x.frameCounts[0] > early.frameCounts[0] + 20 && x.faces[0].map > 0 &&
    x.planeIds[0].length > 0 && x.truthCounts[0] > 20, 'more frames, the map and the truth');
  assert.ok(later.largestErrors[0] > 0 && later.largestErrors[0] < 0.05, `live error ${later.largestErrors[0]} m`);
  assert.ok(BigInt(later.stampNs) > BigInt(early.stampNs));
  await page.shot('live');
  await page.click('#image-triangles');
  await page.until((x) => x.image.triangles === 0, 'no triangles');
  const ended = await page.until((x) => x.ended !== null && x.mode === 'finished' && x.frameCounts[0] > 0 &&
    x.faces[0]?.map > 0, 'the end');
  assert.equal(ended.ended.code, 0);
  assert.equal(ended.faces[0].map, facesOf(join(out, 'map.ply')));
  assert.equal(ended.frameCounts[0], csv(join(out, 'states.csv')).length);
  await runProgram(program, ['evaluate', out, '--truth', recording], 'ignore');
  const { ate } = JSON.parse(readFileSync(join(out, 'evaluation.json'), 'utf8'));
  await page.until((x) => Math.abs(x.largestErrors[0] - ate.max_m) < 2e-6, 'the error of the whole run');
  await page.keyboard.press('Home');
  await page.$eval('#seek', (slider) => {
    slider.value = '5';
    slider.dispatchEvent(new Event('input'));
  });
  const { indices } = await page.stats();
  await page.until((x) => x.image.stampNs === csv(join(out, 'states.csv'))[indices[0]].timestamp_ns &&
    x.image.tracks === 0, 'the recorded image of that moment');
  assert.deepEqual(page.problems, []);
  assert.equal(ended.errors.length, 0);
  assert.equal(await server.stop(), 0);
  await page.until((x) => x.connection === 'lost' || x.connection === 'connecting', 'the loss of the connection');
  await page.close();
});

test('a report holds its runs in 3D and needs no server', async (browser, { folder, result, resultS }) => {
  const report = join(folder, 'report');
  await runProgram(program, ['evaluate', resultS, '--truth', recording, '--against', result, '--report', report], 'ignore');
  for (const width of [1280, 390]) {
    const page = await browser.newPage();
    await page.setOfflineMode(true);
    await page.setViewport({ width, height: 900 });
    await page.goto(`file://${report}/report.html`);
    const images = await page.$$eval('figure image', (all) => all.map((image) => {
      const box = image.getBoundingClientRect(), edges = image.parentElement.querySelectorAll('path');
      return { width: box.width, right: box.right, edges: [...edges].map((e) => e.getAttribute('d').length) };
    }));
    assert.equal(images.length, 4);
    for (const image of images) {
      assert.ok(image.width > 200 && image.right <= width, `an image of ${image.width} px`);
      assert.ok(image.edges.length > 0 && Math.max(...image.edges) > 1000, 'the mesh lies over it');
    }
    if (pictures) await page.$eval('figure image', (image) => image.scrollIntoView());
    if (pictures) await page.screenshot({ path: join(pictures, `report_${width}.png`) });
    await page.$eval('.scene', (frame) => frame.scrollIntoView());
    const frame = await (await page.$('.scene')).contentFrame();
    await frame.waitForFunction('window.facet && window.facet.stats().faces[1]?.map > 0', { timeout: 60000 });
    const s = await frame.evaluate(() => window.facet.stats());
    assert.equal(s.connection, 'stored');
    assert.equal(s.faces[0].map, facesOf(join(resultS, 'map.ply')));
    assert.equal(s.faces[1].map, facesOf(join(result, 'map.ply')));
    assert.deepEqual(s.errors, []);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width, `wider than ${width} px`);
    await page.close();
  }
});

test('a page connects again when the program comes back', async (browser, { result }) => {
  const port = String(20000 + (process.pid % 20000));
  let server = await startProgram(program, ['view', result, '--port', port]);
  const page = await open(browser, server.url, 1280, 800);
  const first = await page.until((x) => x.faces[0]?.map > 0 && x.connection === 'connected', 'the map');
  await server.stop();
  await page.until((x) => x.connection !== 'connected', 'the loss');
  server = await startProgram(program, ['view', result, '--port', port]);
  const again = await page.until((x) => x.connection === 'connected' && x.messages > first.messages, 'the connection');
  assert.equal(again.faces[0].map, first.faces[0].map);
  await page.close();
  await server.stop();
});

// ------------------------------------------------------------------ all of them

const folder = join(work, 'viewer_test');
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
const result = join(folder, 'SPR'), resultS = join(folder, 'S');
const run = ['--duration', '14', '--quiet'];
await runProgram(program, ['run', recording, '--out', result, '--mesh-every', '4', ...run]);
await runProgram(program, ['run', recording, '--out', resultS, '--pipeline', 'S', ...run]);
await runProgram(program, ['evaluate', result, '--truth', recording], 'ignore');
const server = await startProgram(program, ['view', result, '--truth', recording, '--port', '0']);
const browser = await openBrowser(chromium);
let failures = 0;
const chosen = tests.filter(([name]) => name.includes(process.env.ONLY ?? ''));
for (const [name, body] of chosen) {
  const begin = Date.now();
  try {
    await body(browser, { url: server.url, result, resultS, folder });
    console.log(`ok   ${name} (${((Date.now() - begin) / 1000).toFixed(1)} s)`);
  } catch (error) {
    failures++;
    console.log(`FAIL ${name}\n${error.stack}`);
  }
}
await browser.close();
await server.stop();
rmSync(folder, { recursive: true, force: true });
console.log(`${chosen.length - failures} of ${chosen.length} tests passed`);
process.exit(failures === 0 ? 0 : 1);
