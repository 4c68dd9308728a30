// no_allocation.hpp: marks a thread on which every use of the heap ends the test program with a message.
#pragma once

namespace gonio::test {

// Forbids the heap to the calling thread, or allows it again; returns what held before.
bool forbid_heap(bool forbidden);

// The heap is allowed within: for what the test itself does on a forbidden thread.
class Heap_allowed {
public:
    Heap_allowed() : before_(forbid_heap(false)) {}
    Heap_allowed(const Heap_allowed &) = delete;
    Heap_allowed &operator=(const Heap_allowed &) = delete;
    ~Heap_allowed() { forbid_heap(before_); }

private:
    bool before_;
};

} // namespace gonio::test
