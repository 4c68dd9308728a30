// test_no_malloc.cpp: the real-time side allocates nothing, from boot to fault, in any test of this program.
#include "../base/malloc_guard.hpp"
