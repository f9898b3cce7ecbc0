# The commands of talus:  docker build -t talus . && docker run --rm -v "$PWD:/logs" -w /logs talus talus-map LOG.rawlog
ARG SUITE=bookworm
FROM debian:$SUITE AS build
COPY . /talus
RUN cd /talus && apt-get update && ./dev package -DTALUS_WITH_CUDA=OFF
FROM debian:$SUITE
COPY --from=build /talus/build/packages/*.deb /packages/
RUN apt-get update && apt-get install -y --no-install-recommends /packages/talus_*.deb /packages/talus-mrpt-plugin_*.deb \
    mrpt-apps && rm -rf /packages /var/lib/apt/lists/*
CMD ["talus-map", "--help"]
