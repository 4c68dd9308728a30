// no_malloc.hpp: while the core runs, an allocation ends the test program; what the test's ports do meanwhile is free.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace gonio::test {

inline thread_local bool in_core = false;

struct In_core {
    In_core() { in_core = true; }
    ~In_core() { in_core = false; }
    In_core(const In_core &) = delete;
    In_core &operator=(const In_core &) = delete;
};

// A port's function, called by the core.
struct In_port {
    In_port() : before_(in_core) { in_core = false; }
    ~In_port() { in_core = before_; }
    In_port(const In_port &) = delete;
    In_port &operator=(const In_port &) = delete;

private:
    bool before_;
};

inline void no_malloc_here() {
    if (in_core) {
        in_core = false;
        std::fputs("the core allocates memory\n", stderr);
        std::abort();
    }
}

} // namespace gonio::test
