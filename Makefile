# Every target does one thing, by the binary `granary` or by a test program.
# `make demo` and `make test` install what they need on a fresh Debian machine with Rust, node and npm.

CARGO ?= cargo
GRANARY = target/release/granary
ARGS ?=
WHAT ?=

.PHONY: demo test check bench validate presets verify e2e dev web web-test build clean help

help: ## what can be made
	@grep -E '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 12

demo: build ## serve, compute examples/demo.toml, print it beside the published values (ARGS=--exit to end then)
	$(GRANARY) demo $(ARGS)

build: web ## the release binary with the page inside
	$(CARGO) build --release --locked

web: web/dist/index.html ## build the page

web/node_modules: web/package-lock.json
	cd web && PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1 npm ci --no-audit --no-fund
	touch web/node_modules

web/dist/index.html: web/node_modules $(shell find web/src web/scripts web/index.html web/vite.config.ts -type f 2>/dev/null) tests/data/waveform-memory-published.csv
	cd web && npm run build

test: web web-test ## every test that CI runs
	$(CARGO) test --workspace --locked

web-test: web/node_modules
	cd web && npm run check && npm test

check: ## format, lints and docs as errors; licences and sources of dependencies where cargo-deny is installed
	$(CARGO) fmt --all --check
	$(CARGO) clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --locked
	@if $(CARGO) deny --version >/dev/null 2>&1; then $(CARGO) deny --offline check bans licenses sources; \
	else echo "cargo-deny is not installed: dependencies not checked (cargo install cargo-deny)"; fi

bench: ## time the engine on this machine, on a pack of its own
	$(CARGO) build --release --locked
	$(GRANARY) bench $(ARGS)

validate: ## long physics checks: WHAT=numerics|packs|beam|stability
	$(CARGO) test --release --locked -p granary-core --features validation --lib --test validation -- --nocapture $(WHAT)

presets: ## measure again what presets cost in accuracy, for `granary models` and /models
	$(CARGO) build --release --locked
	$(GRANARY) study examples/study-presets-memory.toml --json > docs/presets/memory.json.new
	mv docs/presets/memory.json.new docs/presets/memory.json
	$(GRANARY) study examples/study-presets-beam.toml --archive docs/beam/archive --json > docs/presets/beam.json.new
	mv docs/presets/beam.json.new docs/presets/beam.json

verify: ## long service checks: WHAT=crash|intake|service
	$(CARGO) build --release --locked
	$(CARGO) test --release --locked -p granary-tests --features verification --test verification -- --nocapture --test-threads 1 $(WHAT)

e2e: web ## the page in Debian's Chromium, against the real binary
	command -v chromium >/dev/null || (apt-get update && apt-get install -y chromium)
	$(CARGO) build --locked
	cd web && GRANARY=$$($(CARGO) metadata --no-deps --format-version 1 | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/debug/granary npm run e2e

dev: ## the server on port 8080 with two workers and a throw-away database
	$(CARGO) run -- serve --listen 127.0.0.1:8080 --data .granary/dev --workers 2

clean:
	$(CARGO) clean
	rm -rf web/node_modules web/dist/assets web/dist/index.html*
