# Cross-compiles for arm64 on x86-64, with the compiler and the libraries that Debian has for that (tests/run --arm64).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
# pkg-config would describe the libraries of the machine that compiles.
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig)

# Wheels: patchelf, which renames the libraries that go along, makes room for its table of segments by moving whatever follows it. In
# Debian's libprotobuf for arm64 these are the descriptors, which code finds by their addresses (patchelf 0.15 to 0.18).
set(Protobuf_USE_STATIC_LIBS ON CACHE BOOL "Whether protobuf is linked statically")
