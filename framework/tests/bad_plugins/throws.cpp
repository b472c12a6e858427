// A stage whose constructor throws.
#include <fresco/stage.h>

namespace
{

class Throws final : public fresco::Stage
{
  public:
    Throws() { throw fresco::Error("no license for today"); }
    void run(fresco::RunContext&) override {}
};
FRESCO_STAGE("bad.throws", Throws, "Cannot be made")

}  // namespace
