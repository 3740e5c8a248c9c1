import { defineConfig, type Plugin } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

/** Text files of the project end with a newline; the built page is one of them. */
function endWithNewline(): Plugin {
  return {
    name: 'end-with-newline',
    enforce: 'post',
    generateBundle(_options, bundle) {
      for (const item of Object.values(bundle))
        if (item.type === 'asset' && typeof item.source === 'string')
          item.source = item.source.replace(/[ \t]+$/gm, '').trimEnd() + '\n';
    },
  };
}

export default defineConfig({
  root: 'src',
  plugins: [viteSingleFile({ removeViteModuleLoader: true }), endWithNewline()],
  build: {
    outDir: process.env.SOMAS_WEB_OUT ?? '../dist',
    emptyOutDir: true,
    target: 'es2022',
    modulePreload: { polyfill: false },
    rollupOptions: { input: 'src/replay.html' },
  },
});
