// Its cost goes by an option that it does not have
#include <fresco/mesh.h>
#include <fresco/stage.h>

namespace
{
class Bad final : public fresco::Stage
{
    void run(fresco::RunContext&) override {}
    fresco::Cost cost() const override { return {.makes = {{fresco::count::faces, {.at_most = "max_facez"}}}}; }
};
FRESCO_STAGE("bad.cost", Bad, "Its cost goes by an option that it does not have")
}  // namespace
