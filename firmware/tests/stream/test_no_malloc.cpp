// test_no_malloc.cpp: the stream side allocates nothing, from HELLO to the last sample, in any test of this program.
#include "../base/malloc_guard.hpp"
