// node test.mjs FACET FOLDER RECORDING: what `facet run --record` and `--publish` give, as read by Foxglove's own
// packages. FACET: the program; FOLDER: where results go; RECORDING: four seconds of it are run, or "" for a simulated
// one. Exit code 77 where packages are not there.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, rmSync } from "node:fs";
import { open } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
if (!existsSync(join(here, "node_modules"))) {
  console.log("foxglove: skipped, viewer/foxglove/node_modules is not there; 'npm ci' there installs it");
  process.exit(77);
}
const { FoxgloveClient } = (await import("@foxglove/ws-protocol")).default;
const { McapIndexedReader, McapStreamReader } = await import("@mcap/core");
const { default: Ajv } = await import("ajv");
const { decompress } = await import("fzstd");
const { default: WebSocket } = await import("ws");

const [program, folder, recording] = process.argv.slice(2);
let failures = 0;
function expect(condition, text) {
  if (condition) return;
  ++failures;
  console.error(`foxglove: ${text}`);
}

const TOPICS = {
  "/facet/state": "facet.State",
  "/facet/pose": "foxglove.PoseInFrame",
  "/tf": "foxglove.FrameTransform",
  "/facet/path": "foxglove.PosesInFrame",
  "/facet/mesh": "foxglove.SceneUpdate",
  "/facet/map": "foxglove.SceneUpdate",
  "/facet/planes": "foxglove.SceneUpdate",
  "/facet/image": "foxglove.CompressedImage",
};

// Messages by topic, each checked against the schema that came with its channel.
class Collected {
  messages = new Map(Object.keys(TOPICS).map((topic) => [topic, []]));
  #validators = new Map();

  addChannel(topic, schemaName, schema) {
    expect(TOPICS[topic] === schemaName, `channel ${topic} has the schema ${schemaName}`);
    this.#validators.set(topic, new Ajv({ strict: false }).compile(JSON.parse(schema)));
  }

  add(topic, stampNs, text) {
    const message = JSON.parse(text);
    const validate = this.#validators.get(topic);
    expect(validate(message), `${topic}: ${JSON.stringify(validate.errors)}`);
    const time = message.timestamp;
    if (time) expect(BigInt(time.sec) * 1000000000n + BigInt(time.nsec) === stampNs, `${topic}: another stamp inside`);
    this.messages.get(topic).push({ stampNs, message });
  }
}

function readStates(result) {
  const [head, ...lines] = readFileSync(join(result, "states.csv"), "utf8").trimEnd().split("\n");
  const names = head.split(",");
  return new Map(lines.map((line) => {
    const fields = line.split(",");
    return [BigInt(fields[0]), Object.fromEntries(names.map((name, i) => [name, fields[i]]))];
  }));
}

// What was published is what the result says, frame by frame; returns how many poses were compared.
function compareWithResult(collected, states) {
  for (const { stampNs, message } of collected.messages.get("/facet/pose")) {
    const state = states.get(stampNs);
    expect(state?.px && Math.abs(Number(state.px) - message.pose.position.x) < 1e-9, `pose ${stampNs} is another`);
  }
  for (const { stampNs, message } of collected.messages.get("/facet/state")) {
    const state = states.get(stampNs);
    expect(state?.status === message.status, `status ${stampNs} is another`);
    if (!state?.px) continue;
    expect(Math.abs(Number(state.vz) - message.velocity.z) < 1e-9, `velocity ${stampNs} is another`);
    const sigma = Math.sqrt(message.covariance[3 * 15 + 3]);
    expect(Math.abs(sigma / Number(state.sigma_px) - 1) < 0.5, `sigma ${stampNs}: ${sigma}, ${state.sigma_px}`);
    expect(message.covariance[4] === message.covariance[60], `covariance ${stampNs} is not symmetric`);
  }
  for (const { message } of collected.messages.get("/facet/image").slice(0, 1)) {
    const jpeg = Buffer.from(message.data, "base64");
    expect(jpeg[0] === 0xff && jpeg[1] === 0xd8 && jpeg.at(-2) === 0xff && jpeg.at(-1) === 0xd9, "no JPEG file");
  }
  for (const topic of ["/facet/mesh", "/facet/map"]) {
    for (const { message } of collected.messages.get(topic)) {
      for (const { points, colors, indices } of message.entities.flatMap((entity) => entity.triangles)) {
        expect(points.length === colors.length && indices.length % 3 === 0, `${topic}: lists do not fit`);
        expect(indices.every((i) => i < points.length), `${topic}: an index leads nowhere`);
      }
    }
  }
  return collected.messages.get("/facet/pose").length;
}

async function readMcap(file) {
  const handle = await open(file);
  const readable = {
    size: async () => BigInt((await handle.stat()).size),
    read: async (offset, size) => {
      const buffer = new Uint8Array(Number(size));
      await handle.read(buffer, 0, Number(size), Number(offset));
      return buffer;
    },
  };
  const reader = await McapIndexedReader.Initialize({
    readable,
    decompressHandlers: { zstd: (buffer) => decompress(buffer) },
  });
  const collected = new Collected();
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    expect(channel.messageEncoding === "json" && schema.encoding === "jsonschema", `${channel.topic}: encodings`);
    collected.addChannel(channel.topic, schema.name, new TextDecoder().decode(schema.data));
  }
  expect(reader.chunkIndexes.length > 1, "the chunks have no index");
  let count = 0n;
  for await (const message of reader.readMessages()) {
    collected.add(reader.channelsById.get(message.channelId).topic, message.logTime, new TextDecoder().decode(message.data));
    ++count;
  }
  expect(reader.statistics.messageCount === count, "the statistics count other messages");
  await handle.close();
  return collected;
}

function facet(...args) {
  const run = spawnSync(program, args, { encoding: "utf8" });
  expect(run.status === 0, `facet ${args[0]} ends with ${run.status}: ${run.stderr}`);
  return run;
}

async function testRecord(sequence) {
  const result = join(folder, "recorded"), file = join(folder, "recorded.mcap");
  facet("run", sequence, "--quiet", "--duration", "4", "--out", result, "--record", file);
  const collected = await readMcap(file), states = readStates(result);
  const num_poses = compareWithResult(collected, states);
  expect(collected.messages.get("/facet/state").length === states.size, "not every frame has a state");
  expect(num_poses === [...states.values()].filter((s) => s.px).length, "not every pose was recorded");
  for (const [topic, messages] of collected.messages) expect(messages.length > 0, `${topic} has no message`);
  console.log(`foxglove: ${num_poses} poses recorded and read`);
}

// A run that is killed leaves a file without a summary, in which at most a second is missing.
async function testKilled(sequence) {
  const file = join(folder, "killed.mcap"), result = join(folder, "killed");
  const run = spawn(program, ["run", sequence, "--quiet", "--realtime", "--out", result, "--record", file]);
  await new Promise((resolve) => setTimeout(resolve, 3500));
  run.kill("SIGKILL");
  await new Promise((resolve) => run.on("close", resolve));
  const reader = new McapStreamReader({ decompressHandlers: { zstd: (buffer) => decompress(buffer) } });
  reader.append(readFileSync(`${file}.partial`));
  let last = 0n, count = 0;
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type !== "Message") continue;
    last = record.logTime > last ? record.logTime : last;
    ++count;
  }
  const newest = [...readStates(`${result}.partial`).keys()].at(-1);
  expect(count > 50 && newest - last < 1500000000n, `${count} messages, the last ${newest - last} ns before the newest frame`);
  console.log(`foxglove: ${count} messages read of a run that was killed`);
}

// Subscribes to everything, half of it late.
function listen(url, collected) {
  return new Promise((resolve) => {
    const client = new FoxgloveClient({ ws: new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
    const topics = new Map();
    let info;
    client.on("serverInfo", (event) => (info = event));
    client.on("status", (event) => expect(false, `the server complains: ${event.message}`));
    client.on("error", (event) => expect(false, `error: ${event.message ?? event}`));
    client.on("advertise", (channels) => {
      expect(channels.length === Object.keys(TOPICS).length, `${channels.length} channels`);
      const subscribe = (channel) => topics.set(client.subscribe(channel.id), channel.topic);
      for (const channel of channels) collected.addChannel(channel.topic, channel.schemaName, channel.schema);
      channels.slice(0, 4).forEach(subscribe);
      setTimeout(() => channels.slice(4).forEach(subscribe), 2000);
    });
    client.on("message", ({ subscriptionId, timestamp, data }) =>
      collected.add(topics.get(subscriptionId), timestamp, new TextDecoder().decode(data)));
    client.on("close", () => {
      expect(info?.name.startsWith("facet "), "the server has no name");
      resolve();
    });
  });
}

// The newer name of the protocol, words that nobody understands, and a page of another site.
async function testHandshakes(url) {
  const received = await new Promise((resolve) => {
    const socket = new WebSocket(url, ["foxglove.sdk.v1"]), texts = [];
    socket.on("open", () => {
      expect(socket.protocol === "foxglove.sdk.v1", `protocol ${socket.protocol}`);
      for (const text of ["nonsense", '{"op":"fly"}', '{"op":"subscribe","subscriptions":[{"id":-1}]}']) socket.send(text);
    });
    socket.on("message", (data, isBinary) => {
      expect(!isBinary, "data that nobody has subscribed to");
      texts.push(JSON.parse(data.toString()).op);
      if (texts.length === 5) socket.close();
    });
    socket.on("close", () => resolve(texts));
  });
  expect(received.join() === "serverInfo,advertise,status,status,status", `received ${received}`);
  const refused = await new Promise((resolve) => {
    const socket = new WebSocket(url, ["foxglove.sdk.v1"], { origin: "https://somewhere.else" });
    socket.on("unexpected-response", (_, response) => resolve(response.statusCode));
    socket.on("open", () => resolve("accepted"));
  });
  expect(refused === 403 || refused === 404, `a page of another site: ${refused}`);
}

async function testPublish(sequence) {
  const result = join(folder, "published");
  const run = spawn(program, ["run", sequence, "--quiet", "--realtime", "--duration", "4", "--out", result, "--publish=0"]);
  const ended = new Promise((resolve) => run.on("close", resolve));
  const url = await new Promise((resolve) => {
    let text = "";
    run.stdout.on("data", (data) => {
      text += data;
      const found = text.match(/open (ws:\S+) in Foxglove/);
      if (found) resolve(found[1]);
    });
    run.on("close", () => resolve(""));
  });
  expect(url !== "", "the program does not say where it publishes");
  if (url === "") return;
  const collected = new Collected();
  await Promise.all([listen(url, collected), testHandshakes(url)]);
  const code = await ended;
  expect(code === 0, `facet run --publish ends with ${code}`);
  const states = readStates(result), num_poses = compareWithResult(collected, states);
  // A listener who is slow misses some.
  const share = num_poses / [...states.values()].filter((s) => s.px).length;
  expect(share > 0.3, `only ${(100 * share).toFixed()} % of the poses were received`);
  for (const [topic, messages] of collected.messages) expect(messages.length > 0, `${topic} has no message`);
  console.log(`foxglove: ${num_poses} of ${states.size} poses published and received`);
}

rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
let sequence = recording;
if (!sequence || !existsSync(sequence)) {
  sequence = join(folder, "room");
  facet("simulate", "--out", sequence, "--scene", "room", "--trajectory", "gentle", "--duration", "5");
}
await testRecord(sequence);
await testKilled(sequence);
await testPublish(sequence);
process.exit(failures > 0 ? 1 : 0);
