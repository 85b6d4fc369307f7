// SPDX-License-Identifier: BSD-2-Clause
// Starts the program and a browser for the tests of the page.
import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';

const CHROMIUM = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];

export function findChromium() {
  return CHROMIUM.find((path) => path && existsSync(path));
}

/** Draws with the processor, so that it works without a display and a graphics card. */
export async function openBrowser(executablePath) {
  const { default: puppeteer } = await import('puppeteer-core');
  return puppeteer.launch({
    executablePath,
    headless: true,
    protocolTimeout: 120000,
    args: ['--no-sandbox', '--no-zygote', '--in-process-gpu', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
      '--ignore-gpu-blocklist'],
  });
}

/** `facet` with these arguments; resolves when it prints its address. */
export function startProgram(program, args) {
  const child = spawn(program, args, { stdio: ['ignore', 'pipe', 'pipe'] });
  let output = '', errors = '';
  child.stderr.on('data', (text) => (errors += text));
  const exited = new Promise((resolve) => child.on('exit', (code) => resolve(code)));
  const started = new Promise((resolve, reject) => {
    child.stdout.on('data', (text) => {
      output += text;
      const url = /open (http:\S+)/.exec(output);
      if (url) resolve(url[1]);
    });
    child.on('exit', (code) => reject(new Error(`${program} ended with ${code}: ${errors}`)));
  });
  const stop = async () => {
    child.kill('SIGINT');
    return exited;
  };
  return started.then((url) => ({ url, stop, output: () => output, exited }));
}

export async function runProgram(program, args, output = 'inherit') {
  const child = spawn(program, args, { stdio: ['ignore', output, 'inherit'] });
  const code = await new Promise((resolve) => child.on('exit', resolve));
  if (code !== 0) throw new Error(`${program} ${args.join(' ')} ended with ${code}`);
}
