import { defineConfig } from "vitest/config";

// While the page is worked on (`npm run dev`), the API is that of a running server.
const server = process.env.GRANARY_SERVER ?? "http://127.0.0.1:8000";

export default defineConfig({
  server: {
    // The published results are the repository's, not the page's own.
    fs: { allow: [".."] },
    proxy: { "/api": { target: server, changeOrigin: true } },
  },
  build: { target: "es2022", emptyOutDir: false, assetsInlineLimit: 0, modulePreload: { polyfill: false } },
  test: { include: ["src/**/*.test.ts"] },
});
