// Ends the process in its constructor
#include <cstdlib>
#include <fresco/stage.h>

namespace
{
class Bad final : public fresco::Stage
{
  public:
    Bad() { std::_Exit(0); }
    void run(fresco::RunContext&) override {}
};
FRESCO_STAGE("bad.exits", Bad, "Ends the process in its constructor")
}  // namespace
