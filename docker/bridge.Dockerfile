# For any engine: no instruction here needs BuildKit.
# Built from the project's root: docker build -f docker/bridge.Dockerfile -t handgraft-bridge .

# === Build: the same first layers in every image, so an engine keeps them once
FROM debian:bookworm-slim AS build
RUN apt-get update \
    && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        cmake \
        cyclonedds-dev \
        cyclonedds-tools \
        fastddsgen \
        g++ \
        libassimp-dev \
        libboost-dev \
        libcgal-dev \
        libcli11-dev \
        libedit-dev \
        libeigen3-dev \
        libfastrtps-dev \
        libfmt-dev \
        libgmp-dev \
        libmpfr-dev \
        libnanoflann-dev \
        libnlopt-cxx-dev \
        libnlopt-dev \
        libpng-dev \
        libspdlog-dev \
        libssl-dev \
        libtinyxml2-dev \
        liburdfdom-dev \
        libyaml-cpp-dev \
        ninja-build \
        nlohmann-json3-dev \
        openjdk-17-jre-headless \
        pkg-config \
        python3 \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /src
COPY . .
RUN cmake --preset release -DBUILD_TESTING=OFF \
    && cmake --build --preset release --target handgraft-bridge

# === Run
FROM debian:bookworm-slim
RUN apt-get update \
    && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        libddsc0debian \
        libfastcdr1 \
        libfmt9 \
        libyaml-cpp0.7 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --system --uid 10001 --no-create-home --home-dir /nonexistent \
        --shell /usr/sbin/nologin handgraft
COPY --from=build /src/build/release/bin/handgraft-bridge /usr/local/bin/
# A library that is missing shows here, not at the first start.
RUN handgraft-bridge --help > /dev/null

# Read by the entry point; more options come as arguments.
ENV HANDGRAFT_DOMAIN=0 \
    HANDGRAFT_INTERFACE=eth0
USER 10001
STOPSIGNAL SIGTERM
# No health check: a bridge without a server is well, it waits. Its state is on the topic
# handgraft/v1/bridge_status.
HEALTHCHECK NONE
ENTRYPOINT ["/bin/sh", "-c", "exec handgraft-bridge --domain \"$HANDGRAFT_DOMAIN\" --interface \"$HANDGRAFT_INTERFACE\" \"$@\"", "handgraft-bridge"]
CMD []
