# For any engine: no instruction here needs BuildKit.
# Built from the project's root: docker build -f docker/client.Dockerfile -t handgraft .

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
    && cmake --build --preset release --target handgraft

# === Run
FROM debian:bookworm-slim
RUN apt-get update \
    && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        libddsc0debian \
        libedit2 \
        libfastcdr1 \
        libfmt9 \
        libpng16-16 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --system --uid 10001 --no-create-home --home-dir /nonexistent \
        --shell /usr/sbin/nologin handgraft
COPY --from=build /src/build/release/bin/handgraft /usr/local/bin/
# A library that is missing shows here, not at the first start.
RUN handgraft --help > /dev/null

# Pictures and results are written here: mount a folder.
WORKDIR /data
USER 10001
STOPSIGNAL SIGTERM
HEALTHCHECK NONE
ENTRYPOINT ["handgraft"]
CMD ["doctor", "--interface", "eth0"]
