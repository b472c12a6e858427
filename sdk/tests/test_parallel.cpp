#include "started_program.h"

#include <fresco/error.h>
#include <fresco/parallel.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>
#include <unistd.h>

TEST_CASE("parallel_for covers every item once and its pieces do not depend on the threads")
{
    for (const std::size_t count : {0U, 1U, 7U, 1000U})
        for (const int threads : {1, 2, 5})
        {
            std::vector<int> hits(count, 0);
            std::atomic<bool> even = true;
            fresco::parallel_for(count, 3, threads,
                                 [&](std::size_t begin, std::size_t end)
                                 {
                                     if (begin % 3 != 0 || end - begin > 3)
                                         even = false;
                                     for (std::size_t i = begin; i < end; ++i)
                                         ++hits[i];
                                 });
            CHECK(even);
            CHECK(std::accumulate(hits.begin(), hits.end(), std::size_t{0}) == count);
        }
}

TEST_CASE("parallel_for covers every item when calls are nested, made by several threads at once, and after a fork")
{
    const auto nested = []
    {
        std::vector<std::atomic<int>> hits(40 * 25);
        fresco::parallel_for(40, 1, 4,
                             [&](std::size_t i, std::size_t)
                             { fresco::parallel_for(25, 1, 3, [&](std::size_t j, std::size_t) { ++hits[25 * i + j]; }); });
        return std::all_of(hits.begin(), hits.end(), [](const auto& hit) { return hit == 1; });
    };
    std::atomic<int> right{0};
    {
        std::vector<std::jthread> callers;
        for (int i = 0; i < 4; ++i)
            callers.emplace_back([&] { right += nested() ? 1 : 0; });
    }
    CHECK(right == 4);

    const pid_t child = ::fork();
    if (child == 0)
        ::_exit(nested() ? 7 : 8);
    CHECK(code_of(child) == 7);
}

TEST_CASE("parallel_items calls work for every item once, and stops at a failure or before the next piece once canceled")
{
    struct Stopping final : fresco::Progress
    {
        void check_canceled() const override
        {
            if (pieces_left-- == 0)
                throw fresco::Canceled();
        }
        mutable int pieces_left = 4;
    };
    std::vector<int> hits(10, 0);
    fresco::parallel_items(10, 3, Stopping(), [&](int i) { ++hits.at(static_cast<std::size_t>(i)); });
    CHECK(hits == std::vector<int>(10, 1));
    CHECK_THROWS_AS(fresco::parallel_items(hits.size(), 2, Stopping(), [&](std::size_t i) { ++hits[i]; }), fresco::Canceled);
    CHECK(hits == std::vector<int>{2, 2, 2, 2, 2, 2, 2, 2, 1, 1});
    // The first failure by place is thrown.
    const auto fail_from_4 = [](std::size_t begin, std::size_t)
    {
        if (begin >= 4)
            throw fresco::Error("piece " + std::to_string(begin));
    };
    CHECK_THROWS_WITH(fresco::parallel_for(100, 1, 1, fail_from_4), "piece 4");
    CHECK_THROWS_AS(fresco::parallel_for(100, 1, 4, fail_from_4), fresco::Error);
}

TEST_CASE("parallel_for_each does every item once, reports it and stops when canceled")
{
    struct Told final : fresco::Progress
    {
        void progress(double done, double total, std::string_view unit) override
        {
            const std::lock_guard lock(mutex);
            CHECK((total == 50 && unit == "views"));
            told.insert(done);
        }
        void check_canceled() const override
        {
            const std::lock_guard lock(mutex);
            if (told.size() == limit)
                throw fresco::Canceled();
        }
        int threads() const override { return limit == 3 ? 1 : 4; }
        mutable std::mutex mutex;
        std::set<double> told;
        std::size_t limit = 1000;
    };
    Told told;
    std::vector<int> calls(50);
    const auto call = [&](std::size_t i) { ++calls[i]; };
    fresco::parallel_for_each(calls.size(), "views", told, call);
    CHECK(calls == std::vector<int>(50, 1));
    CHECK((told.told.size() == 50 && *told.told.rbegin() == 50));
    told.told.clear();
    told.limit = 3;
    CHECK_THROWS_AS(fresco::parallel_for_each(calls.size(), "views", told, call), fresco::Canceled);
    CHECK(std::accumulate(calls.begin(), calls.end(), 0) == 53);
}
