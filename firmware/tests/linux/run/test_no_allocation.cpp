// test_no_allocation.cpp: stands before the C library's heap (or hooks the sanitizer's), and shows that it bites.
#include "no_allocation.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <unistd.h>

namespace {

thread_local bool heap_forbidden = false;

void judge(const char *what) {
    if (heap_forbidden) {
        heap_forbidden = false;
        (void)!write(STDERR_FILENO, what, std::strlen(what));
        std::abort();
    }
}

} // namespace

namespace gonio::test {

bool forbid_heap(bool forbidden) {
    bool const before = heap_forbidden;
    heap_forbidden = forbidden;
    return before;
}

} // namespace gonio::test

extern "C" {
#ifdef __SANITIZE_ADDRESS__
void __sanitizer_malloc_hook(const volatile void *, std::size_t) {
    judge("heap used on the real-time thread: allocation\n");
}
void __sanitizer_free_hook(const volatile void *) {
    judge("heap used on the real-time thread: free\n");
}
#else
void *__libc_malloc(std::size_t size);
void *__libc_calloc(std::size_t count, std::size_t size);
void *__libc_realloc(void *memory, std::size_t size);
void *__libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void *memory);

void *malloc(std::size_t size) noexcept {
    judge("heap used on the real-time thread: malloc\n");
    return __libc_malloc(size);
}
void *calloc(std::size_t count, std::size_t size) noexcept {
    judge("heap used on the real-time thread: calloc\n");
    return __libc_calloc(count, size);
}
void *realloc(void *memory, std::size_t size) noexcept {
    judge("heap used on the real-time thread: realloc\n");
    return __libc_realloc(memory, size);
}
void *aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
    judge("heap used on the real-time thread: aligned_alloc\n");
    return __libc_memalign(alignment, size);
}
void free(void *memory) noexcept {
    if (memory != nullptr) { // a thread's end frees what it never had
        judge("heap used on the real-time thread: free\n");
    }
    __libc_free(memory);
}
#endif
}

namespace gonio::test {
namespace {

void *volatile keep; // the compiler may not do without the allocation

TEST(No_allocation, a_forbidden_thread_ends_the_program) {
    EXPECT_DEATH(
        {
            forbid_heap(true);
            keep = std::malloc(16);
        },
        "heap used on the real-time thread");
    void *const memory = std::malloc(16);
    keep = memory;
    EXPECT_DEATH(
        {
            forbid_heap(true);
            std::free(keep);
        },
        "heap used on the real-time thread");
    std::free(memory);
}

TEST(No_allocation, the_tests_own_use_is_allowed) {
    forbid_heap(true);
    {
        Heap_allowed const allowed;
        keep = std::malloc(16);
        std::free(keep);
    }
    EXPECT_TRUE(forbid_heap(false));
}

} // namespace
} // namespace gonio::test
