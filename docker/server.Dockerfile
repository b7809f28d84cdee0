# For any engine: no instruction here needs BuildKit.
# Built from the project's root: docker build -f docker/server.Dockerfile -t handgraft-server .

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
    && cmake --build --preset release --target handgraft-server handgraft

# === Run
FROM debian:bookworm-slim
RUN apt-get update \
    && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        libassimp5 \
        libconsole-bridge1.0 \
        libddsc0debian \
        libfastcdr1 \
        libfastrtps2.9 \
        libfmt9 \
        libgmp10 \
        libmpfr6 \
        libnlopt-cxx0 \
        libnlopt0 \
        libpng16-16 \
        libspdlog1.10 \
        libtinyxml2-9 \
        liburdfdom-model3.0 \
        libyaml-cpp0.7 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --system --uid 10001 --no-create-home --home-dir /nonexistent \
        --shell /usr/sbin/nologin handgraft
# The client comes along for the health check.
COPY --from=build /src/build/release/bin/handgraft-server /src/build/release/bin/handgraft-reader /src/build/release/bin/handgraft /usr/local/bin/
COPY --from=build /src/server/models/hands /usr/local/share/handgraft/models/hands
COPY --from=build /src/server/models/objects /usr/local/share/handgraft/models/objects
COPY --from=build /src/server/models/contacts /usr/local/share/handgraft/models/contacts
# A library that is missing shows here, not at the first start.
RUN handgraft-server --help > /dev/null && handgraft --help > /dev/null

# Read by the entry point and the health check alike; more options come as arguments.
ENV HANDGRAFT_DOMAIN=0 \
    HANDGRAFT_INTERFACE=eth0
USER 10001
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=30s --timeout=10s --retries=3 \
    CMD handgraft doctor --domain "$HANDGRAFT_DOMAIN" --interface "$HANDGRAFT_INTERFACE"
ENTRYPOINT ["/bin/sh", "-c", "exec handgraft-server --domain \"$HANDGRAFT_DOMAIN\" --interface \"$HANDGRAFT_INTERFACE\" \"$@\"", "handgraft-server"]
CMD []
