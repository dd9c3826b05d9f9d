# docker build -t borelli . && docker run --rm -v "$PWD:/data" borelli run scan.nii.gz --quantity hu -o out
FROM debian:12 AS build
WORKDIR /borelli
COPY . .
RUN ./build.sh run && apt-get install -y -qq --no-install-recommends dpkg-dev file && \
    cmake --build build/release && cpack --config build/release/CPackConfig.cmake -B /packages

FROM debian:12
COPY --from=build /packages/borelli_*.deb /packages/
RUN apt-get update -qq && apt-get install -y -qq --no-install-recommends /packages/borelli_*.deb ffmpeg && \
    rm -rf /packages /var/lib/apt/lists/*
WORKDIR /data
ENTRYPOINT ["borelli"]
