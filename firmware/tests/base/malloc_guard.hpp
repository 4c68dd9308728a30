// malloc_guard.hpp: takes the place of the C library's allocation in a test program, for all its tests; include it in
// one file of the program.
#pragma once

#include <gtest/gtest.h>

#include "no_malloc.hpp"

#if defined(__SANITIZE_ADDRESS__)
TEST(No_malloc, stops_an_allocation_of_the_core) {
    GTEST_SKIP() << "the address sanitizer has its own malloc";
}
#else
extern "C" {
void *__libc_malloc(std::size_t size);
void *__libc_calloc(std::size_t count, std::size_t size);
void *__libc_realloc(void *block, std::size_t size);

void *malloc(std::size_t size) {
    gonio::test::no_malloc_here();
    return __libc_malloc(size);
}
void *calloc(std::size_t count, std::size_t size) {
    gonio::test::no_malloc_here();
    return __libc_calloc(count, size);
}
void *realloc(void *block, std::size_t size) {
    gonio::test::no_malloc_here();
    return __libc_realloc(block, size);
}
}

TEST(No_malloc, stops_an_allocation_of_the_core) {
    void *volatile kept = nullptr;
    {
        gonio::test::In_core const core;
        gonio::test::In_port const port;
        kept = std::malloc(1);
    }
    EXPECT_NE(kept, nullptr);
    std::free(kept);
    EXPECT_DEATH(
        {
            gonio::test::In_core const core;
            kept = std::malloc(1);
        },
        "the core allocates memory");
}
#endif
