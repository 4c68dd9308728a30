// test_event_loop.cpp: what came from outside is served before the devices live through the moment when it came.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "event_loop.hpp"

namespace gonio::sim {
namespace {

class Told final : public Source {
public:
    explicit Told(std::vector<std::string> &story) : story_(story) {}
    void wait_for(std::vector<pollfd> &) const override {}
    void serve() override { story_.emplace_back("served"); }
    [[nodiscard]] bool stamped() const override { return true; }

private:
    std::vector<std::string> &story_;
};

} // namespace

TEST(Event_loop, ServesFirstThenLivesUpToThePresentAndNoFurther) {
    Scheduler scheduler(monotonic_ns());
    std::vector<std::string> story;
    Told source(story);
    Event_loop loop(scheduler);
    loop.add(source);
    loop.on_turn = [&] { story.emplace_back("turned"); };
    scheduler.after(0, [&] { story.emplace_back("due"); });
    std::int64_t const much_later_ns = scheduler.now_ns() + 3600000000000;
    scheduler.at(much_later_ns, [&] { story.emplace_back("not yet"); });
    loop.turn(0);
    EXPECT_EQ(story, (std::vector<std::string>{"served", "due", "turned"}));
    EXPECT_LE(scheduler.now_ns(), monotonic_ns());
    EXPECT_EQ(scheduler.next_ns(), much_later_ns);
}

TEST(Event_loop, WaitsForTheSchedulersNextEvent) {
    Scheduler scheduler(monotonic_ns());
    Event_loop loop(scheduler);
    bool happened = false;
    std::int64_t const due_ns = scheduler.now_ns() + 3000000;
    scheduler.at(due_ns, [&] { happened = true; });
    for (int turn = 0; turn < 1000 && !happened; ++turn) {
        loop.turn(60000000000);
    }
    EXPECT_TRUE(happened);
    EXPECT_GE(monotonic_ns(), due_ns);
}

TEST(Event_loop, EndsWhenTold) {
    Scheduler scheduler(monotonic_ns());
    Event_loop loop(scheduler);
    std::atomic<bool> ended{false};
    int turns = 0;
    loop.on_turn = [&] { ended = ++turns == 3; };
    for (int k = 0; k < 5; ++k) {
        scheduler.after(k, [] {});
    }
    scheduler.after(1000000, [] {});
    scheduler.after(2000000, [] {});
    loop.run(ended);
    EXPECT_EQ(turns, 3);
}

} // namespace gonio::sim
