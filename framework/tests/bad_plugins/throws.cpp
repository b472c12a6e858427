// Throws in its constructor
#include <fresco/stage.h>

namespace
{
class Bad final : public fresco::Stage
{
  public:
    Bad() { throw fresco::Error("no license for today"); }
    void run(fresco::RunContext&) override {}
};
FRESCO_STAGE("bad.throws", Bad, "Throws in its constructor")
}  // namespace
