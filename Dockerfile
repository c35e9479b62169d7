# The binary with the page inside, on a plain Debian.
FROM node:20-bookworm-slim AS page
WORKDIR /src
COPY web web
COPY tests/data tests/data
RUN cd web && PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1 npm ci --no-audit --no-fund && npm run build

FROM rust:1-bookworm AS build
WORKDIR /src
COPY . .
COPY --from=page /src/web/dist web/dist
RUN cargo build --release --locked

FROM debian:bookworm-slim
COPY --from=build /src/target/release/granary /usr/local/bin/granary
# A new volume takes its owner from the folder that it is mounted on.
RUN mkdir /data && chown 10001:10001 /data
USER 10001:10001
VOLUME /data
ENTRYPOINT ["granary"]
