// Crashes in its constructor
#include <csignal>
#include <fresco/stage.h>

namespace
{
class Bad final : public fresco::Stage
{
  public:
    Bad() { (void)std::raise(SIGSEGV); }
    void run(fresco::RunContext&) override {}
};
FRESCO_STAGE("bad.crashes", Bad, "Crashes in its constructor")
}  // namespace
