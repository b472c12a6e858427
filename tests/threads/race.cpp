// Two threads that write one number: a race on purpose, between two pieces of parallel_for.
#include <fresco/parallel.h>

#include <cstdio>
#include <thread>

int main()
{
    int last = 0;
    fresco::parallel_for(2, 1, 2,
                         [&](std::size_t piece, std::size_t)
                         {
                             last = static_cast<int>(piece);
                             // Until the other thread has taken the other piece.
                             std::this_thread::sleep_for(std::chrono::milliseconds(200));
                         });
    std::printf("%d\n", last);
}
