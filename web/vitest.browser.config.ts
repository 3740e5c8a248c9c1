import { defineConfig } from 'vitest/config';

// A real browser on a busy machine takes its time.
export default defineConfig({
  test: { include: ['browser/**/*.test.ts'], testTimeout: 120_000, hookTimeout: 300_000, fileParallelism: false },
});
