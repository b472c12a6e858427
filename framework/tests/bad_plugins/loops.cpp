// Never leaves its constructor
#include <atomic>
#include <fresco/stage.h>

namespace
{
class Bad final : public fresco::Stage
{
  public:
    Bad()
    {
        for (std::atomic<int> i = 0; i >= 0; i = (i + 1) % 1000)
            continue;
    }
    void run(fresco::RunContext&) override {}
};
FRESCO_STAGE("bad.loops", Bad, "Never leaves its constructor")
}  // namespace
