# armhf.cmake: CMake toolchain file for 32-bit ARM boards with a floating-point unit (ARMv7).
set(debian_architecture armhf)
set(triplet arm-linux-gnueabihf)
set(CMAKE_SYSTEM_PROCESSOR armv7)
include(${CMAKE_CURRENT_LIST_DIR}/debian.cmake)
