#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace fresco::optimize
{

/// Makes the items first, first + 1, …, last - 1 in order on a thread of its own, at most `depth` ahead of who takes them. An
/// exception of `make` is rethrown where its item would be taken. The destructor waits for the item under way.
template <class T>
class Prefetch
{
  public:
    Prefetch(std::size_t first, std::size_t last, std::size_t depth, std::function<T(std::size_t)> make)
        : last_(last), depth_(depth), make_(std::move(make)), thread_([this, first](std::stop_token stop) { work(stop, first); })
    {
    }

    /// The next item; blocks until it is there. At most last - first calls.
    T next()
    {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return !ready_.empty() || failure_; });
        if (ready_.empty())
            std::rethrow_exception(failure_);
        T item = std::move(ready_.front());
        ready_.pop_front();
        changed_.notify_all();
        return item;
    }

  private:
    void work(const std::stop_token& stop, std::size_t first)
    {
        try
        {
            for (std::size_t i = first; i < last_; ++i)
            {
                {
                    std::unique_lock lock(mutex_);
                    if (!changed_.wait(lock, stop, [this] { return ready_.size() < depth_; }))
                        return;
                }
                if (stop.stop_requested())
                    return;
                T item = make_(i);
                const std::lock_guard lock(mutex_);
                ready_.push_back(std::move(item));
                changed_.notify_all();
            }
        }
        catch (...)
        {
            const std::lock_guard lock(mutex_);
            failure_ = std::current_exception();
            changed_.notify_all();
        }
    }

    std::size_t last_;
    std::size_t depth_;
    std::function<T(std::size_t)> make_;
    std::mutex mutex_;
    std::condition_variable_any changed_;
    std::deque<T> ready_;
    std::exception_ptr failure_;
    std::jthread thread_;  ///< Last: it is joined before what it uses goes.
};

}  // namespace fresco::optimize
