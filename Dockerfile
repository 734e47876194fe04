# kinegraph in a container: docker build -t kinegraph .
#   docker run --rm -v "$PWD":/work kinegraph demo
#
# The steps of the second stage are those of tests/install/bare_root.sh, which
# runs them in a bare Debian 12 without Docker. docs/porting.md states how the
# image was tested.
FROM debian:12 AS build
COPY cmake/debian_packages.txt /tmp/
RUN apt-get update && apt-get install -y --no-install-recommends dpkg-dev file \
      $(awk '$1 == "build" { print $2 }' /tmp/debian_packages.txt)
COPY . /src
RUN cmake -S /src -B /build -G Ninja -DCMAKE_BUILD_TYPE=Release \
      -DKINEGRAPH_TESTS=OFF \
    && cmake --build /build && cd /build && cpack -G DEB

FROM debian:12-slim
COPY --from=build /build/kinegraph_*.deb /tmp/
RUN apt-get update \
    && apt-get install -y --no-install-recommends /tmp/kinegraph_*.deb \
      python3-numpy gnuplot-nox python3-h5py python3-scipy ffmpeg \
    && rm -rf /tmp/kinegraph_*.deb /var/lib/apt/lists/*
WORKDIR /work
ENTRYPOINT ["kinegraph"]
CMD ["help"]
