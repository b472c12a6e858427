#include <fresco/parallel.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

namespace fresco
{

void parallel_for(std::size_t count, std::size_t grain, int threads, const std::function<void(std::size_t, std::size_t)>& work)
{
    if (count == 0)
        return;
    grain = std::max<std::size_t>(grain, 1);
    const std::size_t pieces = (count + grain - 1) / grain;
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::exception_ptr failure;
    std::size_t failed_piece = std::numeric_limits<std::size_t>::max();

    const auto drain = [&]
    {
        for (std::size_t piece = next++; piece < pieces; piece = next++)
        {
            try
            {
                work(piece * grain, std::min(count, (piece + 1) * grain));
            }
            catch (...)
            {
                // Pieces are handed out in order, so every piece before the failed one has begun: the smallest number wins.
                const std::lock_guard lock(mutex);
                if (piece < failed_piece)
                {
                    failed_piece = piece;
                    failure = std::current_exception();
                }
                next = pieces;
            }
        }
    };

    const std::size_t helpers = std::min(pieces, static_cast<std::size_t>(std::max(threads, 1))) - 1;
    {
        std::vector<std::jthread> pool;
        pool.reserve(helpers);
        for (std::size_t i = 0; i < helpers; ++i)
            pool.emplace_back(drain);
        drain();
    }
    if (failure)
        std::rethrow_exception(failure);
}

}  // namespace fresco
