#include <fresco/parallel.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <thread>
#include <unistd.h>
#include <vector>

namespace fresco
{
namespace
{

/// Threads that wait for work, as many as a caller ever asked for: buffers that kernels keep per thread outlive a call. Never
/// destroyed: at the program's end its threads still wait.
class Helpers
{
  public:
    /// Helpers of this process: a fork leaves the threads behind.
    static Helpers& here()
    {
        static std::mutex mutex;
        static Helpers* helpers = nullptr;
        static pid_t process = 0;
        const std::lock_guard lock(mutex);
        if (helpers == nullptr || process != ::getpid())
        {
            helpers = new Helpers;
            process = ::getpid();
        }
        return *helpers;
    }

    /// Work for the helper threads, until it is withdrawn.
    struct Call
    {
        std::function<void()> work;
        std::size_t invited = 0;
        std::size_t working = 0;
    };

    /// Lets as many helpers as the call invites, as soon as they are free, do its work once each.
    void invite(Call& call)
    {
        const std::lock_guard lock(mutex_);
        calls_.push_back(&call);
        try
        {
            for (; threads_ < call.invited; ++threads_)
                std::thread([this] { wait_for_calls(); }).detach();
        }
        catch (const std::exception&)
        {
            // No thread, or no memory for one: the caller does the work with the threads there are.
        }
        for (std::size_t i = 0; i < call.invited; ++i)
            invited_.notify_one();
    }

    /// Invites no more helpers, and returns when all have left the call.
    void take_back(Call& call)
    {
        std::unique_lock lock(mutex_);
        std::erase(calls_, &call);
        left_.wait(lock, [&] { return call.working == 0; });
    }

  private:
    void wait_for_calls()
    {
        std::unique_lock lock(mutex_);
        while (true)
        {
            // The innermost of nested calls first: the others wait for it.
            const auto found = std::find_if(calls_.rbegin(), calls_.rend(), [](const Call* call) { return call->invited > 0; });
            if (found == calls_.rend())
            {
                invited_.wait(lock);
                continue;
            }
            Call& call = **found;
            --call.invited;
            ++call.working;
            lock.unlock();
            call.work();
            lock.lock();
            if (--call.working == 0)
                left_.notify_all();
        }
    }

    std::mutex mutex_;
    std::condition_variable invited_;
    std::condition_variable left_;
    std::vector<Call*> calls_;
    std::size_t threads_ = 0;
};

}  // namespace

void parallel_for(std::size_t count, std::size_t grain, const Progress& progress,
                  const std::function<void(std::size_t, std::size_t)>& work)
{
    parallel_for(count, grain, progress.threads(), work);
}

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

    const auto do_piece = [&](std::size_t piece)
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
    };
    const auto do_pieces = [&]
    {
        for (std::size_t piece = next++; piece < pieces; piece = next++)
            do_piece(piece);
    };

    Helpers::Call call{std::ref(do_pieces), std::min(static_cast<std::size_t>(std::max(threads, 1)), pieces) - 1};
    Helpers* helpers = call.invited > 0 ? &Helpers::here() : nullptr;
    if (helpers != nullptr)
        helpers->invite(call);
    do_pieces();
    if (helpers != nullptr)
        helpers->take_back(call);
    if (failure)
        std::rethrow_exception(failure);
}

void parallel_for_each(std::size_t count, std::string_view unit, Progress& progress, const std::function<void(std::size_t)>& work)
{
    std::atomic<std::size_t> done{0};
    parallel_for(count, 1, progress,
                 [&](std::size_t i, std::size_t)
                 {
                     progress.check_canceled();
                     work(i);
                     progress.progress(static_cast<double>(++done), static_cast<double>(count), unit);
                 });
}

}  // namespace fresco
