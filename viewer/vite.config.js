// SPDX-License-Identifier: BSD-2-Clause
// Builds viewer/dist, which is committed: the same sources and lock file give the same bytes.
import { readFileSync } from 'node:fs';
import { defineConfig } from 'vite';

/** The licences of what is in the bundle, as a file beside it. */
function licences() {
  const parts = [
    ['Facet', '../LICENSE'],
    ['three.js', 'node_modules/three/LICENSE'],
  ];
  return {
    name: 'licences',
    generateBundle() {
      const source = parts
        .map(([name, file]) => `${name}\n\n${readFileSync(new URL(file, import.meta.url), 'utf8')}`)
        .join('\n----\n\n');
      this.emitFile({ type: 'asset', fileName: 'licences.txt', source });
    },
  };
}

export default defineConfig({
  base: './',
  plugins: [licences()],
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    modulePreload: false,
    chunkSizeWarningLimit: 1000,
    rollupOptions: {
      output: { entryFileNames: 'page.js', assetFileNames: 'page[extname]', inlineDynamicImports: true },
    },
  },
});
